#include "output/progress.hpp"

#include <cstdio>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode Progress::begin(MPI_Comm comm, double seconds) {
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  comm_ = comm;
  is_first_rank_ = rank == 0;
  seconds_ = seconds;
  begin_ = last_ = MPI_Wtime();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Progress::pass(const std::string &work) {
  PetscLogDouble bytes = 0;
  PetscFunctionBeginUser;
  if (!is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMemoryGetCurrentUsage(&bytes));
  PetscCallMPI(MPI_Reduce(&bytes, &bytes_, 1, MPI_DOUBLE, MPI_MAX, 0, comm_));
  if (is_due()) show(work);
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool Progress::is_due() const {
  return is_on() && is_first_rank_ && MPI_Wtime() - last_ >= seconds_;
}

void Progress::show(const std::string &work) {
  last_ = MPI_Wtime();
  std::fprintf(stderr, "%.0f s, %.2f GB on the largest rank: %s\n", last_ - begin_, bytes_ / 1e9,
               work.c_str());
}

}  // namespace trefoil
