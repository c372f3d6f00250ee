#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/config/bad_input.h"
#include "host/export/hdf5.h"
#include "host/export/lost.h"
#include "host/export/waveforms.h"

namespace powbench::host {

#ifndef POWBENCH_HDF5

bool can_write_netcdf() {
  return false;
}

void write_netcdf(const Record&, const About&, const std::string& path) {
  throw BadInput({path + ": this powbench was built without HDF5; install libhdf5-dev and build again, or "
                         "use csv, comtrade or xlsx"});
}

#else

namespace {

constexpr unsigned truncate = 2;                   // H5F_ACC_TRUNC, whose macro calls the library
constexpr std::size_t longest_attribute = 60'000;  // bytes; the format of 1.8 takes less than 64 KiB

/// A handle of the library, closed at the end.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw BadInput({"HDF5 refuses: the disk is full, or the folder cannot be written"});
  }
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: handles are numbers to the library

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void must(herr_t status) {
  if (status < 0) throw BadInput({"HDF5 refuses: the disk is full, or the folder cannot be written"});
}

void attribute(hid_t at, const char* name, const std::string& text) {
  must(scales().H5LTset_attribute_string(at, ".", name, text.c_str()));
}
void attribute(hid_t at, const char* name, double value) {
  must(scales().H5LTset_attribute_double(at, ".", name, &value, 1));
}

Handle dataset(hid_t file, const std::string& name, hid_t type, hid_t memory, const void* data, hsize_t n) {
  const Handle space(hdf5().H5Screate_simple(1, &n, nullptr), hdf5().H5Sclose);
  const Handle how(hdf5().H5Pcreate(hdf5().h5p_dataset_create), hdf5().H5Pclose);
  const hsize_t chunk = std::min<hsize_t>(n, 16'384);
  must(hdf5().H5Pset_chunk(how, 1, &chunk));
  must(hdf5().H5Pset_shuffle(how));
  must(hdf5().H5Pset_deflate(how, 1));
  must(hdf5().H5Pset_attr_creation_order(how, H5P_CRT_ORDER_TRACKED));
  const hid_t id = hdf5().H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, how, H5P_DEFAULT);
  if (id >= 0) must(hdf5().H5Dwrite(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
  return Handle(id, hdf5().H5Dclose);
}

void write(const Record& r, const About& about, const std::string& path) {
  const Handle how(hdf5().H5Pcreate(hdf5().h5p_file_create), hdf5().H5Pclose);
  must(hdf5().H5Pset_link_creation_order(how, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
  must(hdf5().H5Pset_attr_creation_order(how, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
  const Handle file(hdf5().H5Fcreate(path.c_str(), truncate, how, H5P_DEFAULT), hdf5().H5Fclose);
  const Handle root(hdf5().H5Gopen2(file, "/", H5P_DEFAULT), hdf5().H5Gclose);
  for (const auto& [key, text] : about)
    if (text.size() < longest_attribute) attribute(root, key.c_str(), text);
  const auto n = static_cast<hsize_t>(r.samples());
  std::vector<double> values(r.samples());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = r.time(i);
  const Handle time =
      dataset(file, "time", hdf5().h5t_ieee_f64le, hdf5().h5t_native_double, values.data(), n);
  must(scales().H5DSset_scale(time, "time"));
  attribute(time, "units", "s");
  attribute(time, "long_name", "time after the gate edge, the zero of the record");
  const auto add = [&](const std::string& name, hid_t type, hid_t memory, const void* data, auto&& describe) {
    const Handle d = dataset(file, name, type, memory, data, n);
    must(scales().H5DSattach_scale(d, time, 0));
    describe(d);
  };
  for (const ChannelRecord& c : r.channels) {
    const std::string name(info(c.channel).name);
    const std::vector<bool> lost = lost_samples(r, c);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = lost[i] ? std::nan("") : c.value(i);
    add(name, hdf5().h5t_ieee_f64le, hdf5().h5t_native_double, values.data(), [&](hid_t d) {
      attribute(d, "units", std::string(info(c.channel).unit));
      attribute(d, "long_name", std::string(info(c.channel).meaning));
      attribute(d, "delay_s", c.delay);
      attribute(d, "corner_hertz", c.corner_hertz);
    });
    add(name + "_counts", hdf5().h5t_std_i16le, hdf5().h5t_native_int16, c.raw.data(), [&](hid_t d) {
      attribute(d, "long_name",
                "counts of the converter; value = (count + offset) scale; lost samples hold any count");
      attribute(d, "scale", c.scale);
      attribute(d, "offset", c.offset);
    });
  }
}

}  // namespace

bool can_write_netcdf() {
  return true;
}

void write_netcdf(const Record& r, const About& about, const std::string& path) {
  if (r.samples() == 0) throw BadInput({path + ": the record has no samples"});
  hdf5().H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // one sentence, not its stack
  const std::string aside = path + ".part";
  try {
    write(r, about, aside);
    std::filesystem::rename(aside, path);
  } catch (const BadInput& e) {
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    throw BadInput({path + ": cannot be written: " + e.what()});
  }
}

#endif

}  // namespace powbench::host
