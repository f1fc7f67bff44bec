#include "input/scene_file.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <utility>

#include "input/yaml_document.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Lists of named parts, and what an option of one part begins with.
const std::map<std::string, std::string> singular{
    {"constraints", "constraint"}, {"regions", "region"}, {"loads", "load"},
    {"probes", "probe"},           {"bodies", "body"},    {"obstacles", "obstacle"}};

bool is_option(const std::string &word) {
  PetscBool valid = PETSC_FALSE;
  static_cast<void>(PetscOptionsValidKey(word.c_str(), &valid));
  return valid == PETSC_TRUE;
}

/// The walk through one file.
class Flattener {
 public:
  explicit Flattener(YamlDocument &document) : document_(document) {}

  void add_mapping(const yaml_node_t *map, const std::string &prefix, bool is_merged = false);

  std::vector<std::string> words;
  std::map<std::string, std::vector<std::string>> names;  ///< of nested parts, by list

 private:
  using Pair = std::pair<const yaml_node_t *, const yaml_node_t *>;

  std::vector<Pair> pairs_of(const yaml_node_t *map) const;
  void add_merged(const yaml_node_t *node, const std::string &prefix);
  void add_named(const std::string &list, const yaml_node_t *parts);
  void add_sequence(const std::string &name, const yaml_node_t *sequence, bool is_merged);
  void add(const yaml_node_t *where, const std::string &name, const std::string *value,
           bool is_merged);

  YamlDocument &document_;
  std::map<std::string, std::size_t> line_of_;  ///< of each option that is set
};

std::vector<Flattener::Pair> Flattener::pairs_of(const yaml_node_t *map) const {
  std::vector<Pair> pairs;
  std::map<std::string, std::size_t> lines;
  for (const auto *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
       ++pair) {
    const yaml_node_t *key = document_.node(pair->key);
    if (key->type != YAML_SCALAR_NODE) document_.refuse(key, "a key must be a name");
    const std::string name = text_of(key);
    const auto [first, is_new] = lines.emplace(name, key->start_mark.line + 1);
    if (!is_new) {
      document_.refuse(key, "'" + name + "' is written twice, first in line " +
                                std::to_string(first->second) + "; put both together");
    }
    pairs.emplace_back(key, document_.node(pair->value));
  }
  return pairs;
}

void Flattener::add(const yaml_node_t *where, const std::string &name, const std::string *value,
                    bool is_merged) {
  const bool is_plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.';
  });
  if (!is_plain || !is_option("-" + name)) {
    document_.refuse(where, "'" + name + "' makes no option: names have letters, digits and _");
  }
  if (name == "options_file") {
    document_.refuse(where, "a scene file reads no other; name both: trefoil one.yaml two.yaml");
  }
  if (!is_merged) {
    const auto [first, is_new] = line_of_.emplace(name, where->start_mark.line + 1);
    if (!is_new) {
      document_.refuse(
          where, "-" + name + " is set twice, first in line " + std::to_string(first->second));
    }
  }
  words.push_back("-" + name);
  if (value) words.push_back(is_option(*value) ? " " + *value : *value);
}

void Flattener::add_sequence(const std::string &name, const yaml_node_t *sequence, bool is_merged) {
  std::string list;
  for (const int *item = sequence->data.sequence.items.start;
       item < sequence->data.sequence.items.top; ++item) {
    const yaml_node_t *node = document_.node(*item);
    if (node->type != YAML_SCALAR_NODE) {
      document_.refuse(node,
                       "a list holds names or numbers; parts with keys of their own are "
                       "written by name, " +
                           name + ": {NAME: {...}}");
    }
    list += (list.empty() ? "" : ", ") + text_of(node);
  }
  add(sequence, name, &list, is_merged);
}

/// `constraints: {wall: {group: wall}}`: what it says of each part, and the parts' names.
void Flattener::add_named(const std::string &list, const yaml_node_t *parts) {
  for (const auto &[key, value] : pairs_of(parts)) {
    const std::string name = text_of(key), option = singular.at(list) + "_" + name;
    names[list].push_back(name);
    if (value->type == YAML_MAPPING_NODE) {
      add_mapping(value, option + "_");
    } else if (value->type == YAML_SCALAR_NODE && !is_null(value)) {
      const std::string text = text_of(value);
      add(value, option, &text, false);
    } else if (value->type == YAML_SEQUENCE_NODE) {
      add_sequence(option, value, false);
    }
  }
}

void Flattener::add_merged(const yaml_node_t *node, const std::string &prefix) {
  if (node->type == YAML_SEQUENCE_NODE) {
    for (const int *item = node->data.sequence.items.start; item < node->data.sequence.items.top;
         ++item) {
      add_merged(document_.node(*item), prefix);
    }
  } else if (node->type == YAML_MAPPING_NODE) {
    add_mapping(node, prefix, true);
  } else {
    document_.refuse(node, "<< merges mappings only");
  }
}

void Flattener::add_mapping(const yaml_node_t *map, const std::string &prefix, bool is_merged) {
  const std::vector<Pair> pairs = pairs_of(map);
  for (const auto &[key, value] : pairs) {  // what is merged comes first: the rest wins
    if (text_of(key) == "<<") add_merged(value, prefix);
  }
  for (const auto &[key, value] : pairs) {
    const std::string last = text_of(key), name = prefix + last;
    if (last == "<<" || last.rfind("$$", 0) == 0) continue;
    if (value->type == YAML_MAPPING_NODE && prefix.empty() && singular.count(last)) {
      add_named(last, value);
    } else if (value->type == YAML_MAPPING_NODE && !pairs_of(value).empty()) {
      add_mapping(value, name + "_", is_merged);
    } else if (value->type == YAML_SEQUENCE_NODE) {
      add_sequence(name, value, is_merged);
    } else if (value->type == YAML_MAPPING_NODE || is_null(value)) {  // {} says as little
      add(key, name, nullptr, is_merged);
    } else {
      const std::string text = text_of(value);
      add(value, name, &text, is_merged);
    }
  }
}

std::string content_of(const std::string &path) {
  const auto refuse = [&](const std::string &why) {
    throw InputError("cannot read the scene file '" + path + "': " + why);
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) refuse("it is a directory; name a file in it");
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(std::string(std::strerror(errno)) + "; check its name");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Refuses `constraints: {wall: ...}` beside `constraint: {wall: ...}`.
void refuse_twofold(YamlDocument &document, const yaml_node_t *root,
                    const std::map<std::string, std::vector<std::string>> &names) {
  const auto find = [&](const yaml_node_t *map, const std::string &name) -> const yaml_node_t * {
    for (const auto *pair = map->data.mapping.pairs.start; pair < map->data.mapping.pairs.top;
         ++pair) {
      if (text_of(document.node(pair->key)) == name) return document.node(pair->value);
    }
    return nullptr;
  };
  for (const auto &[list, parts] : names) {
    const std::string &one = singular.at(list);
    const yaml_node_t *section = find(root, one);
    if (!section || section->type != YAML_MAPPING_NODE) continue;
    for (const std::string &part : parts) {
      if (const yaml_node_t *twice = find(section, part)) {
        document.refuse(twice, "'" + part + "' is written under " + list + " and under " + one +
                                   "; put both together under " + list);
      }
    }
  }
}

}  // namespace

std::vector<std::string> SceneFileReader::read(const std::string &path) {
  const std::string text = content_of(path);
  YamlDocument document(path, text);
  const yaml_node_t *root = document.root();
  if (!root || is_null(root)) return {};
  if (root->type != YAML_MAPPING_NODE) {
    document.refuse(root, "a scene is keys and values, such as mesh: {file: a.msh}");
  }
  if (document.has_another()) {
    document.refuse(root, "a second document follows; write each into a file of its own");
  }
  Flattener flattener(document);
  flattener.add_mapping(root, "");
  refuse_twofold(document, root, flattener.names);
  for (const auto &[list, parts] : flattener.names) {
    std::vector<std::string> &all = names_[list];
    for (const std::string &part : parts) {
      if (std::find(all.begin(), all.end(), part) == all.end()) all.push_back(part);
    }
    std::string joined;
    for (const std::string &part : all) joined += (joined.empty() ? "" : ",") + part;
    flattener.words.insert(flattener.words.end(), {"-" + list, joined});
  }
  return flattener.words;
}

}  // namespace trefoil
