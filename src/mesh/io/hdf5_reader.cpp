#include "mesh/io/hdf5_reader.hpp"

#include <petscsys.h>

#include <array>
#include <cstdint>

#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// A dataset and its space, closed at the end.
struct Opened {
  hid_t dataset = -1, space = -1;
  std::array<hsize_t, 2> shape{0, 1};
  int dimensions = 0;

  Opened(hid_t file, const std::string &name) {
    dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    if (dataset >= 0) space = H5Dget_space(dataset);
    if (space >= 0) dimensions = H5Sget_simple_extent_ndims(space);
    if (dimensions == 1 || dimensions == 2)
      H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    else
      dimensions = 0;
  }
  ~Opened() {
    if (space >= 0) H5Sclose(space);
    if (dataset >= 0) H5Dclose(dataset);
  }
  Opened(const Opened &) = delete;
  Opened &operator=(const Opened &) = delete;
};

}  // namespace

Hdf5Reader::Hdf5Reader(const std::string &path, const char *advice) : path_(path), advice_(advice) {
  H5Eget_auto2(H5E_DEFAULT, &printer_, &printer_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ >= 0) return;
  H5Eset_auto2(H5E_DEFAULT, printer_, printer_data_);
  throw InputError(path_ + " cannot be read as HDF5: it is truncated or damaged" + advice_);
}

Hdf5Reader::~Hdf5Reader() {
  H5Fclose(file_);
  H5Eset_auto2(H5E_DEFAULT, printer_, printer_data_);
}

void Hdf5Reader::fail(const std::string &sentence) const {
  throw InputError(path_ + " " + sentence + advice_);
}

bool Hdf5Reader::has(const std::string &dataset) const {
  return Opened(file_, dataset).dimensions > 0;
}

PetscInt Hdf5Reader::size(const std::string &dataset) const {
  const Opened opened(file_, dataset);
  if (opened.dimensions == 0) fail("has no list " + dataset + " of numbers");
  const hsize_t rows = opened.shape[0], width = opened.shape[1];
  if (width > 0 && rows > static_cast<hsize_t>(PETSC_MAX_INT) / width)
    throw InputError(path_ + " has more numbers in " + dataset +
                     " than this PETSc can count; use a PETSc with 64-bit indices");
  return static_cast<PetscInt>(rows * width);
}

void Hdf5Reader::read(const std::string &name, hid_t type, H5T_class_t kind, PetscInt first,
                      PetscInt count, void *numbers) const {
  if (count == 0) return;
  const Opened opened(file_, name);
  const hsize_t width = opened.shape[1];
  const hid_t stored = H5Dget_type(opened.dataset);
  const bool is_of_kind = H5Tget_class(stored) == kind;
  H5Tclose(stored);
  const auto begin = static_cast<hsize_t>(first), length = static_cast<hsize_t>(count);
  if (!is_of_kind || begin % width || length % width || begin + length > opened.shape[0] * width)
    fail("has other numbers in " + name + " than it should have");
  const std::array<hsize_t, 2> start{begin / width, 0}, rows{length / width, width};
  const hid_t memory = H5Screate_simple(1, &length, nullptr);
  const bool is_read =
      H5Sselect_hyperslab(opened.space, H5S_SELECT_SET, start.data(), nullptr, rows.data(),
                          nullptr) >= 0 &&
      H5Dread(opened.dataset, type, memory, opened.space, H5P_DEFAULT, numbers) >= 0;
  H5Sclose(memory);
  if (!is_read) fail("is damaged in " + name);
}

PetscInt Hdf5Reader::attribute(const std::string &dataset, const std::string &name) const {
  std::int64_t number = -1;
  const hid_t attribute =
      H5Aopen_by_name(file_, dataset.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
  if (attribute < 0) return -1;
  if (H5Aread(attribute, H5T_NATIVE_INT64, &number) < 0) number = -1;
  H5Aclose(attribute);
  return static_cast<PetscInt>(number);
}

std::vector<PetscInt> Hdf5Reader::integers(const std::string &dataset, PetscInt first,
                                           PetscInt count) const {
  const hid_t type = sizeof(PetscInt) == sizeof(std::int32_t) ? H5T_NATIVE_INT32 : H5T_NATIVE_INT64;
  std::vector<PetscInt> numbers(static_cast<std::size_t>(count));
  read(dataset, type, H5T_INTEGER, first, count, numbers.data());
  return numbers;
}

std::vector<double> Hdf5Reader::reals(const std::string &dataset, PetscInt first,
                                      PetscInt count) const {
  std::vector<double> numbers(static_cast<std::size_t>(count));
  read(dataset, H5T_NATIVE_DOUBLE, H5T_FLOAT, first, count, numbers.data());
  return numbers;
}

}  // namespace trefoil
