#include <algorithm>
#include <sstream>

#include "mesh/distribution.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Tells all ranks the groups, which the first one knows.
PetscErrorCode tell_groups(MPI_Comm comm, const Groups &whole, Groups *groups) {
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  GroupTables message;
  if (rank == 0) message = pack_groups(whole);
  PetscMPIInt sizes[2] = {static_cast<PetscMPIInt>(message.numbers.size()),
                          static_cast<PetscMPIInt>(message.names.size())};
  PetscCallMPI(MPI_Bcast(sizes, 2, MPI_INT, 0, comm));
  message.numbers.resize(static_cast<std::size_t>(sizes[0]));
  message.names.resize(static_cast<std::size_t>(sizes[1]));
  PetscCallMPI(MPI_Bcast(message.numbers.data(), sizes[0], MPIU_INT, 0, comm));
  PetscCallMPI(MPI_Bcast(message.names.data(), sizes[1], MPI_CHAR, 0, comm));
  unpack_groups(message, groups);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A rank for each entity: that of a cell that has all of its corners; -1: there is none.
std::vector<PetscInt> ranks_of(const CellList &whole, const GroupedEntities &entities,
                               const std::vector<PetscInt> &rank_of_cell) {
  std::vector<PetscInt> ranks(entities.size(), -1);
  if (ranks.empty()) return ranks;
  const std::size_t corners = entities.vertices.size() / entities.size();
  // The entities by their first corner.
  std::vector<PetscInt> start(static_cast<std::size_t>(whole.vertices()) + 1, 0);
  std::vector<std::size_t> sorted(entities.size());
  const auto first = [&](std::size_t e) {
    return static_cast<std::size_t>(entities.vertices[corners * e]);
  };
  for (std::size_t e = 0; e < ranks.size(); ++e) ++start[first(e) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<PetscInt> next(start);
  for (std::size_t e = 0; e < ranks.size(); ++e) {
    sorted[static_cast<std::size_t>(next[first(e)]++)] = e;
  }
  const auto width = static_cast<std::size_t>(whole.nodes_per_cell());
  for (std::size_t c = 0; c < rank_of_cell.size(); ++c) {
    const PetscInt *cell = &whole.cells[width * c], *end = cell + whole.corners();
    for (const PetscInt *vertex = cell; vertex < end; ++vertex) {
      const auto v = static_cast<std::size_t>(*vertex);
      for (PetscInt k = start[v]; k < start[v + 1]; ++k) {
        const std::size_t e = sorted[static_cast<std::size_t>(k)];
        const PetscInt *corner = &entities.vertices[corners * e];
        if (ranks[e] < 0 && std::all_of(corner, corner + corners, [&](PetscInt each) {
              return std::find(cell, end, each) < end;
            })) {
          ranks[e] = rank_of_cell[c];
        }
      }
    }
  }
  return ranks;
}

/// What each rank gets: for each dimension a number of entities, their sets and their corners.
std::vector<std::vector<PetscInt>> divide(const CellList &whole, const Partition &partition,
                                          std::size_t ranks) {
  std::vector<std::vector<PetscInt>> shares(ranks);
  for (const GroupedEntities &entities : whole.groups.below) {
    const std::vector<PetscInt> rank = ranks_of(whole, entities, partition.rank_of_cell);
    const std::size_t corners = entities.size() ? entities.vertices.size() / entities.size() : 0;
    std::vector<GroupedEntities> parts(ranks);
    for (std::size_t e = 0; e < entities.size(); ++e) {
      if (rank[e] < 0) continue;
      GroupedEntities &part = parts[static_cast<std::size_t>(rank[e])];
      const auto corner = entities.vertices.begin() + static_cast<std::ptrdiff_t>(corners * e);
      part.vertices.insert(part.vertices.end(), corner,
                           corner + static_cast<std::ptrdiff_t>(corners));
      part.sets.push_back(entities.sets[e]);
    }
    for (std::size_t p = 0; p < ranks; ++p) {
      std::vector<PetscInt> &share = shares[p];
      share.push_back(static_cast<PetscInt>(parts[p].size()));
      share.insert(share.end(), parts[p].sets.begin(), parts[p].sets.end());
      share.insert(share.end(), parts[p].vertices.begin(), parts[p].vertices.end());
    }
  }
  return shares;
}

}  // namespace

/// Between the body of a group and its name.
constexpr char end_of_body = '\x1f';

GroupTables pack_groups(const Groups &groups) {
  GroupTables tables;
  tables.numbers.push_back(static_cast<PetscInt>(groups.list().size()));
  for (const Group &group : groups.list()) {
    tables.numbers.insert(tables.numbers.end(), {group.dimension, group.number});
    if (!group.body.empty()) tables.names += group.body + end_of_body;
    tables.names += group.name + '\0';
  }
  for (const std::vector<int> &set : groups.sets()) {
    tables.numbers.push_back(static_cast<PetscInt>(set.size()));
    tables.numbers.insert(tables.numbers.end(), set.begin(), set.end());
  }
  return tables;
}

void unpack_groups(const GroupTables &tables, Groups *groups) {
  auto number = tables.numbers.begin();
  std::istringstream names(tables.names);
  const auto take = [&](PetscInt least, PetscInt most) {
    if (number == tables.numbers.end() || *number < least || *number > most)
      throw InputError("its tables of groups are damaged");
    return *number++;
  };
  const PetscInt count = take(0, PETSC_MAX_INT);
  for (PetscInt group = 0; group < count; ++group) {
    std::string name, body;
    std::getline(names, name, '\0');
    if (const auto end = name.find(end_of_body); end != std::string::npos) {
      body = name.substr(0, end);
      name.erase(0, end + 1);
    }
    const auto dimension = static_cast<int>(take(0, 3));
    if (groups->add(dimension, take(PETSC_MIN_INT, PETSC_MAX_INT), body) != group)
      throw InputError("its tables of groups are damaged");
    groups->name(static_cast<int>(group), name);
  }
  while (number != tables.numbers.end()) {
    std::vector<int> set(static_cast<std::size_t>(take(0, count)));
    for (int &group : set) group = static_cast<int>(take(0, count - 1));
    groups->set_of(set);
  }
}

void take_entities(const std::vector<PetscInt> &share, const std::vector<PetscInt> &whole_number,
                   const CellShape &shape, Groups *groups) {
  std::vector<std::pair<PetscInt, PetscInt>> local;  // by whole number
  if (share.size() > groups->below.size()) {
    for (std::size_t v = 0; v < whole_number.size(); ++v) {
      local.emplace_back(whole_number[v], static_cast<PetscInt>(v));
    }
    std::sort(local.begin(), local.end());
  }
  std::vector<std::ptrdiff_t> corners(groups->below.size(), 0);
  for (const CellShape *facet = shape.facet; facet; facet = facet->facet) {
    corners[static_cast<std::size_t>(facet->dimension)] = facet->corners;
  }
  auto next = share.begin();
  for (std::size_t dimension = 0; dimension < groups->below.size(); ++dimension) {
    GroupedEntities &entities = groups->below[dimension];
    const auto count = static_cast<std::ptrdiff_t>(*next++);
    entities.sets.assign(next, next + count);
    next += count;
    for (const auto end = next + count * corners[dimension]; next != end; ++next) {
      const auto found =
          std::lower_bound(local.begin(), local.end(), std::pair{*next, PetscInt{0}});
      if (found == local.end() || found->first != *next)
        throw InputError("what is in a group has a corner that its cell has not");
      entities.vertices.push_back(found->second);
    }
  }
}

PetscErrorCode distribute_groups(MPI_Comm comm, const CellList &whole, const Partition &partition,
                                 const std::vector<PetscInt> &whole_number, Mesh *mesh) {
  PetscMPIInt rank = 0, ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(tell_groups(comm, whole.groups, &mesh->groups));
  std::vector<PetscMPIInt> counts(static_cast<std::size_t>(ranks), 0);
  std::vector<PetscInt> all, mine;
  if (rank == 0) {
    std::size_t p = 0;
    for (const auto &share : divide(whole, partition, counts.size())) {
      counts[p++] = static_cast<PetscMPIInt>(share.size());
      all.insert(all.end(), share.begin(), share.end());
    }
  }
  PetscCall(scatter(comm, MPIU_INT, all, counts, &mine));
  take_entities(mine, whole_number, *mesh->shape, &mesh->groups);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode count_groups(MPI_Comm comm, Mesh *mesh) {
  Groups &groups = mesh->groups;
  std::vector<PetscInt> of_set(groups.sets().size(), 0), of_group(groups.list().size(), 0);
  PetscFunctionBeginUser;
  for (const PetscInt set : groups.set_of_cell) ++of_set[static_cast<std::size_t>(set)];
  for (const GroupedEntities &entities : groups.below) {
    for (const PetscInt set : entities.sets) ++of_set[static_cast<std::size_t>(set)];
  }
  for (std::size_t set = 0; set < of_set.size(); ++set) {
    for (const int group : groups.sets()[set]) {
      of_group[static_cast<std::size_t>(group)] += of_set[set];
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, of_group.data(),
                             static_cast<PetscMPIInt>(of_group.size()), MPIU_INT, MPI_SUM, comm));
  for (std::size_t g = 0; g < of_group.size(); ++g)
    groups.set_count(static_cast<int>(g), of_group[g]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
