#include "support/collective_error.hpp"

#include <new>

#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

PetscErrorCode agree_on_complaint(MPI_Comm comm, const std::string &complaint,
                                  PetscErrorCode code) {
  PetscMPIInt rank = 0, ranks = 0, speaker = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  speaker = complaint.empty() ? ranks : rank;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &speaker, 1, MPI_INT, MPI_MIN, comm));
  if (speaker == ranks) PetscFunctionReturn(PETSC_SUCCESS);
  std::string sentence = complaint;
  auto length = static_cast<PetscMPIInt>(sentence.size());
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, speaker, comm));
  sentence.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(sentence.data(), length, MPI_CHAR, speaker, comm));
  SETERRQ(comm, code, "%s", sentence.c_str());
}

std::string complaint_of(const std::function<void()> &action) {
  try {
    action();
  } catch (const InputError &error) {
    return error.what();
  } catch (const std::bad_alloc &) {
    return "there is not enough memory";
  }
  return "";
}

}  // namespace trefoil
