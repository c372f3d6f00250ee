#pragma once

#ifdef POWBENCH_HDF5

#include <hdf5.h>
#include <hdf5_hl.h>

#include "core/late_library.h"
#include "host/config/bad_input.h"

namespace powbench::host {

/// HDF5, which brings curl and Kerberos with it: loaded by the first file.
struct Hdf5 {
  LateLibrary library{POWBENCH_HDF5};
  POWBENCH_LATE(H5Dclose);
  POWBENCH_LATE(H5Dcreate2);
  POWBENCH_LATE(H5Dwrite);
  POWBENCH_LATE(H5Eset_auto2);
  POWBENCH_LATE(H5Fclose);
  POWBENCH_LATE(H5Fcreate);
  POWBENCH_LATE(H5Gclose);
  POWBENCH_LATE(H5Gopen2);
  POWBENCH_LATE(H5Pclose);
  POWBENCH_LATE(H5Pcreate);
  POWBENCH_LATE(H5Pset_attr_creation_order);
  POWBENCH_LATE(H5Pset_chunk);
  POWBENCH_LATE(H5Pset_deflate);
  POWBENCH_LATE(H5Pset_link_creation_order);
  POWBENCH_LATE(H5Pset_shuffle);
  POWBENCH_LATE(H5Sclose);
  POWBENCH_LATE(H5Screate_simple);
  POWBENCH_LATE(H5open);
  /// Numbers of types and lists, there once the library is open.
  hid_t number(const char* name) const {
    return H5open() < 0 ? H5I_INVALID_HID : *library.find<const hid_t*>(name);
  }
  hid_t h5p_dataset_create = number("H5P_CLS_DATASET_CREATE_ID_g");
  hid_t h5p_file_create = number("H5P_CLS_FILE_CREATE_ID_g");
  hid_t h5t_ieee_f64le = number("H5T_IEEE_F64LE_g");
  hid_t h5t_native_double = number("H5T_NATIVE_DOUBLE_g");
  hid_t h5t_native_int16 = number("H5T_NATIVE_INT16_g");
  hid_t h5t_std_i16le = number("H5T_STD_I16LE_g");
};

/// Its second library: dimensions and attributes.
struct Hdf5Scales {
  LateLibrary library{POWBENCH_HDF5_HL};
  POWBENCH_LATE(H5DSattach_scale);
  POWBENCH_LATE(H5DSset_scale);
  POWBENCH_LATE(H5LTset_attribute_double);
  POWBENCH_LATE(H5LTset_attribute_string);
};

/// Throws BadInput if it is not installed.
template <class Library>
const Library& late_hdf5() try {
  static const Library one;
  return one;
} catch (const std::runtime_error& e) {
  throw BadInput(
      {std::string("HDF5 ") + e.what() + "; install libhdf5-hl-100, or use csv, comtrade or xlsx"});
}
inline const Hdf5& hdf5() {
  return late_hdf5<Hdf5>();
}
inline const Hdf5Scales& scales() {
  return late_hdf5<Hdf5Scales>();
}

}  // namespace powbench::host

#endif
