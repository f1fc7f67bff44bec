#pragma once

#include <hdf5.h>
#include <petscsystypes.h>

#include <string>
#include <vector>

namespace trefoil {

/// An HDF5 file that this rank reads alone, or beside others. Errors are InputErrors of one
/// sentence that names the file; HDF5's own words are kept silent.
class Hdf5Reader {
 public:
  /// @param advice what to do about a file that is not as it should be, the end of each sentence
  explicit Hdf5Reader(const std::string &path,
                      const char *advice = "; write it again by -mesh_write");
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader &) = delete;
  Hdf5Reader &operator=(const Hdf5Reader &) = delete;

  [[nodiscard]] bool has(const std::string &dataset) const;
  /// Numbers in a dataset: rows x width. Refuses what PetscInt cannot count.
  [[nodiscard]] PetscInt size(const std::string &dataset) const;
  /// Numbers first ... first + count - 1 of a dataset of two columns' dimensions at most.
  [[nodiscard]] std::vector<PetscInt> integers(const std::string &dataset, PetscInt first,
                                               PetscInt count) const;
  [[nodiscard]] std::vector<double> reals(const std::string &dataset, PetscInt first,
                                          PetscInt count) const;
  /// An attribute of a dataset, or -1 where there is none.
  [[nodiscard]] PetscInt attribute(const std::string &dataset, const std::string &name) const;
  /// "big.h5 is ..., so ..."
  [[noreturn]] void fail(const std::string &sentence) const;

 private:
  void read(const std::string &dataset, hid_t type, H5T_class_t kind, PetscInt first,
            PetscInt count, void *numbers) const;

  std::string path_, advice_;
  hid_t file_ = -1;
  H5E_auto2_t printer_ = nullptr;
  void *printer_data_ = nullptr;
};

}  // namespace trefoil
