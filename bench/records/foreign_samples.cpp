#include "bench/records/foreign_samples.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/random.h"

namespace powbench::host {
namespace {

std::string rows(const Waves& w, const std::function<std::string(std::size_t)>& row) {
  std::string out;
  for (std::size_t i = 0; i < w.ch1.size(); ++i) out += row(i);
  return out;
}
double time(const Waves& w, std::size_t i) {
  return w.start + w.step * static_cast<double>(i);
}
std::string comma(double v) {
  std::string text = fmt::format("{}", v);
  std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

template <class T>
void put(std::string& to, T value, bool big = false) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if (big) std::reverse(bytes, bytes + sizeof value);
  to.append(bytes, sizeof value);
}
void text(std::string& to, const std::string& s, bool big) {
  put(to, static_cast<std::uint32_t>(s.size()), big);
  to += s;
}

std::string plain_rows(const Waves& w) {
  return rows(w, [&](std::size_t i) { return fmt::format("{},{},{}\n", time(w, i), w.ch1[i], w.ch2[i]); });
}

// --- TDMS ---

struct TdmsWay {
  bool big = false, mixed = false;
  std::size_t chunks = 1, segments = 1;
};

std::string tdms_segment(const Waves& w, const TdmsWay& way, std::size_t from, std::size_t n, bool first) {
  const bool b = way.big;
  const std::size_t per = n / way.chunks;
  std::string meta, raw;
  put(meta, std::uint32_t{first ? 4U : 2U}, b);
  const auto object = [&](const std::string& path, int index) {
    text(meta, path, b);
    if (index == 0) put(meta, 0xFFFFFFFFU, b);
    if (index == 1)
      put(meta, 20U, b), put(meta, 10U, b), put(meta, 1U, b), put(meta, static_cast<std::uint64_t>(per), b);
    if (index == 2) put(meta, 0U, b);
  };
  if (first) {
    object("/", 0), put(meta, 1U, b), text(meta, "name", b), put(meta, 0x20U, b), text(meta, "made here", b);
    object("/'Group'", 0), put(meta, 0U, b);
  }
  for (const char* name : {"CH1", "CH2"}) {
    object(std::string("/'Group'/'") + name + "'", first ? 1 : 2);
    put(meta, first ? 3U : 0U, b);
    if (!first) continue;
    text(meta, "wf_increment", b), put(meta, 10U, b), put(meta, w.step, b);
    text(meta, "wf_start_offset", b), put(meta, 10U, b), put(meta, w.start, b);
    text(meta, "unit_string", b), put(meta, 0x20U, b), text(meta, "Volts", b);
  }
  for (std::size_t c = 0; c < way.chunks; ++c) {
    const std::size_t at = from + c * per;
    for (std::size_t k = 0; !way.mixed && k < 2; ++k)
      for (std::size_t i = 0; i < per; ++i) put(raw, (k == 0 ? w.ch1 : w.ch2)[at + i], b);
    for (std::size_t i = 0; way.mixed && i < per; ++i) put(raw, w.ch1[at + i], b), put(raw, w.ch2[at + i], b);
  }
  std::string out = "TDSm";
  put(out, static_cast<std::uint32_t>(2U | (first ? 4U : 0U) | 8U | (way.mixed ? 32U : 0U) | (b ? 64U : 0U)));
  put(out, 4713U, b);
  put(out, static_cast<std::uint64_t>(meta.size() + raw.size()), b);
  put(out, static_cast<std::uint64_t>(meta.size()), b);
  return out + meta + raw;
}

std::string tdms(const Waves& w, const TdmsWay& way) {
  const std::size_t n = w.ch1.size() / way.segments;
  std::string out;
  for (std::size_t s = 0; s < way.segments; ++s) out += tdms_segment(w, way, s * n, n, s == 0);
  return out;
}

// --- MAT 5 ---

void pad(std::string& s) {
  s.resize((s.size() + 7) / 8 * 8, '\0');
}
void element(std::string& to, std::uint32_t type, const std::string& data, bool b) {
  put(to, type, b), put(to, static_cast<std::uint32_t>(data.size()), b);
  to += data;
  pad(to);
}

std::string mat_variable(const std::string& name, const std::vector<double>& v, bool b, bool single_row,
                         bool counts) {
  std::string flags, dims, numbers, body;
  put(flags, 6U, b), put(flags, 0U, b);
  const auto n = static_cast<std::int32_t>(v.size());
  put(dims, single_row ? std::int32_t{1} : n, b), put(dims, single_row ? n : std::int32_t{1}, b);
  for (const double x : v) {
    if (counts)
      put(numbers, static_cast<std::int16_t>(x), b);
    else
      put(numbers, x, b);
  }
  element(body, 6, flags, b), element(body, 5, dims, b);
  if (name.size() <= 4) {  // the small form
    put(body, static_cast<std::uint32_t>(name.size() << 16 | 1U), b);
    std::string four = name;
    four.resize(4, '\0');
    body += four;
  } else {
    element(body, 1, name, b);
  }
  element(body, counts ? 3 : 9, numbers, b);
  std::string out;
  element(out, 14, body, b);
  return out;
}

std::string zipped(const std::string& variable, bool b) {
  std::string packed(compressBound(variable.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(variable.data()),
           variable.size());
  std::string out;
  put(out, 15U, b), put(out, static_cast<std::uint32_t>(size), b);
  return out + packed.substr(0, size);
}

std::string mat(const Waves& w, bool b, bool packed, bool with_time, bool row) {
  std::string out = "MATLAB 5.0 MAT-file, made here";
  out.resize(124, ' ');
  put(out, std::uint16_t{0x0100}, b);
  out += b ? "MI" : "IM";
  std::vector<double> t(w.ch1.size());
  for (std::size_t i = 0; i < t.size(); ++i) t[i] = time(w, i);
  std::vector<std::string> variables;
  if (with_time)
    variables.push_back(mat_variable("time", t, b, row, false));
  else
    variables.push_back(mat_variable("Tinterval", {w.step}, b, row, false)),
        variables.push_back(mat_variable("Tstart", {w.start}, b, row, false));
  variables.push_back(mat_variable("CH1", w.ch1, b, row, false));
  variables.push_back(mat_variable("CH2", w.ch2, b, row, false));
  for (const std::string& v : variables) out += packed ? zipped(v, b) : v;
  return out;
}

// --- Yokogawa ---

Foreign yokogawa(const Waves& w, bool b, bool blocks) {
  const std::size_t many = blocks ? 2 : 1, n = w.ch1.size() / many;
  Foreign f{.name = fmt::format("Yokogawa, {}, {}", b ? "big" : "little", blocks ? "blocks" : "traces"),
            .file = "x.wvf",
            .bytes = "",
            .header = ""};
  f.header = fmt::format(
      "//YOKOGAWA ASCII FILE FORMAT\r\n\r\n$PublicInfo\r\nFormatVersion      1.11\r\nModel              made "
      "here\r\nEndian             {}\r\n"
      "DataFormat         {}\r\nGroupNumber        1\r\nTraceTotalNumber   2\r\nDataOffset         "
      "4\r\n\r\n$Group1\r\nTraceNumber        2\r\n"
      "BlockNumber        {}\r\nTraceName          CH1          CH2\r\nBlockSize          {}          {}\r\n"
      "VResolution        9.765625E-04 9.765625E-04\r\nVOffset            0.0 0.0\r\nVDataType          IS2 "
      "IS2\r\nVUnit              V V\r\n"
      "HResolution        {} {}\r\nHOffset            {} {}\r\nHUnit              s "
      "s\r\n\r\n$PrivateInfo\r\nModelVersion 1\r\n",
      b ? "Big" : "Ltl", blocks ? "Block" : "Trace", many, n, n, w.step, w.step, w.start, w.start);
  f.bytes = "skip";
  for (std::size_t block = 0; block < many; ++block)
    for (const auto* v : {&w.ch1, &w.ch2})
      for (std::size_t i = 0; i < n; ++i)
        put(f.bytes, static_cast<std::int16_t>((*v)[block * n + i] * 1024), b);
  return f;
}

}  // namespace

Waves waves(std::uint64_t seed, std::size_t samples) {
  Random random(seed);
  Waves w;
  for (std::size_t i = 0; i < samples; ++i) {
    w.ch1.push_back(std::round(1024 * 10 * std::sin(0.031 * static_cast<double>(i))) / 1024);
    w.ch2.push_back(std::round(1024 * (random.uniform() * 8 - 4)) / 1024);
  }
  return w;
}

std::vector<Foreign> scope_texts(const Waves& w) {
  const std::size_t n = w.ch1.size();
  std::vector<Foreign> list;
  const auto add = [&](const std::string& name, const std::string& bytes, int channels = 2) {
    list.push_back({.name = name, .file = "x.csv", .bytes = bytes, .header = "", .channels = channels});
  };
  // Tektronix TDS: settings beside the numbers
  const std::vector<std::string> settings{fmt::format("Record Length,{:.6e}", static_cast<double>(n)),
                                          fmt::format("Sample Interval,{}", w.step),
                                          "Trigger Point,2.0e+03",
                                          ",",
                                          ",",
                                          ",",
                                          "Source,CH1",
                                          "Vertical Units,V",
                                          "Vertical Scale,5.0",
                                          "Vertical Offset,0.0",
                                          "Horizontal Units,s",
                                          "Horizontal Scale,2.5e-04",
                                          "Pt Fmt,Y",
                                          "Yzero,0",
                                          "Probe Atten,1.0e+01",
                                          "Model Number,TDS2024",
                                          "Serial Number,C0",
                                          "Firmware Version,FV:v1"};
  add("Tektronix TDS",
      rows(w,
           [&](std::size_t i) {
             return fmt::format("{},,{:.12f}, {},\r\n", i < settings.size() ? settings[i] : ",", time(w, i),
                                w.ch1[i]);
           }),
      1);
  add("Tektronix DPO", fmt::format("Model,MDO4104C\nFirmware Version,1.0\n\nPoint Format,Y,\nHorizontal "
                                   "Units,S,\nHorizontal Scale,0.004,\n"
                                   "Sample Interval,{},\nRecord Length,{},\nGating,0.0% to 100.0%,\nProbe "
                                   "Attenuation,10,1\nVertical Units,V,V\n"
                                   "Vertical Offset,0,0\nVertical Scale,1,1\nLabel,,\nTIME,CH1,CH2\n",
                                   w.step, n) +
                           plain_rows(w));
  add("Keysight InfiniiVision", "x-axis,1,2\nsecond,Volt,Volt\n" + plain_rows(w));
  add("Keysight Infiniium",
      fmt::format("Revision:,0\nType:,raw\nStart:,0\nPoints:,{}\nCount:,1\nXDispRange:,1.0\nXUnits:,"
                  "second\nYUnits:,Volt\n"
                  "XInc:,{}\nXOrg:,{}\nFrame:,X\nDate:,04 MAY 2026\nData:\n",
                  n, w.step, w.start) +
          rows(w, [&](std::size_t i) { return fmt::format("{},{}\n", time(w, i), w.ch1[i]); }),
      1);
  add("Rigol DS1000Z",
      fmt::format("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,{:.6e},{:.6e}\n", w.start, w.step) +
          rows(w, [&](std::size_t i) { return fmt::format("{},{},{},\n", i, w.ch1[i], w.ch2[i]); }));
  add("Rigol MSO5000",
      fmt::format("CH1V,CH2V,t0 ={}, tInc = {},\n", w.start, w.step) +
          rows(w, [&](std::size_t i) { return fmt::format("{},{},,\n", w.ch1[i], w.ch2[i]); }));
  add("Rigol with times", "Time(s),CH1(V),CH2(V)\n" + plain_rows(w));
  add("Rohde & Schwarz RTB", "in s,C1 in V,C2 in V\n" + plain_rows(w));
  add("LeCroy",
      fmt::format(
          "LECROYWS64Xs,50123,Waveform\r\nSegments,1,SegmentSize,{}\r\nSegment,TrigTime,TimeSinceSegment1\r\n"
          "#1,04-May-2026 10:12:13,0                 \r\nTime,Ampl\r\n",
          n) +
          rows(w, [&](std::size_t i) { return fmt::format("{},{}\r\n", time(w, i), w.ch1[i]); }),
      1);
  add("Siglent", fmt::format("Record Length,Analog:{}\nSample Interval,Analog:{}\nVertical "
                             "Units,CH1:V,CH2:V\nVertical Scale,CH1:1,CH2:1\n"
                             "Horizontal Units,s\nModel Number,SDS\nSerial Number,X\nSoftware "
                             "Version,1\nSource,CH1,CH2\nSecond,Volt,Volt\n",
                             n, w.step) +
                     plain_rows(w));
  add("Pico", "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n" + rows(w, [&](std::size_t i) {
                return fmt::format("{},{},{}\n", 1e3 * time(w, i), w.ch1[i], 1e3 * w.ch2[i]);
              }));
  add("semicolons, decimal commas", "Zeit (s);CH1 (V);CH2 (V)\r\n" + rows(w, [&](std::size_t i) {
                                      return comma(time(w, i)) + ";" + comma(w.ch1[i]) + ";" +
                                             comma(w.ch2[i]) + "\r\n";
                                    }));
  add("tabs, decimal commas, Latin-1 micro", "Time/\xB5s\tCH1/V\tCH2/V\n" + rows(w, [&](std::size_t i) {
                                               return comma(1e6 * time(w, i)) + "\t" + comma(w.ch1[i]) +
                                                      "\t" + comma(w.ch2[i]) + "\n";
                                             }));
  return list;
}

std::vector<Foreign> binary_files(const Waves& w) {
  std::vector<Foreign> list;
  const auto add = [&](const std::string& name, const std::string& file, const std::string& bytes) {
    list.push_back({.name = name, .file = file, .bytes = bytes, .header = ""});
  };
  add("TDMS", "x.tdms", tdms(w, {}));
  add("TDMS, big-endian, interleaved", "x.tdms", tdms(w, {.big = true, .mixed = true}));
  add("TDMS, two segments of two chunks", "x.tdms", tdms(w, {.chunks = 2, .segments = 2}));
  add("MAT 5", "x.mat", mat(w, false, false, true, false));
  add("MAT 5, packed", "x.mat", mat(w, false, true, false, true));
  add("MAT 5, big-endian", "x.mat", mat(w, true, false, false, false));
  for (const bool big : {false, true})
    for (const bool blocks : {false, true}) list.push_back(yokogawa(w, big, blocks));
  return list;
}

std::vector<Foreign> logger_files(const Waves& w) {
  std::string samples, wav = "RIFF";
  for (std::size_t i = 0; i < w.ch1.size(); ++i)
    put(samples, static_cast<float>(w.ch1[i])), put(samples, static_cast<float>(w.ch2[i]));
  const auto hertz = static_cast<std::uint32_t>(std::lround(1 / w.step));
  put(wav, static_cast<std::uint32_t>(36 + samples.size()));
  wav += "WAVEfmt ";
  put(wav, std::uint32_t{16}), put(wav, std::uint16_t{3}), put(wav, std::uint16_t{2});
  put(wav, hertz), put(wav, 8 * hertz), put(wav, std::uint16_t{8}), put(wav, std::uint16_t{32});
  wav += "data";
  put(wav, static_cast<std::uint32_t>(samples.size()));
  std::string lvm =
      "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t2\n"
      "Y_Unit_Label\tVolts\tVolts\n***End_of_Header***\nX_Value\tA\tB\tComment\n";
  lvm +=
      rows(w, [&](std::size_t i) { return fmt::format("{:.6f}\t{}\t{}\n", time(w, i), w.ch1[i], w.ch2[i]); });
  return {{.name = "WAV, float", .file = "x.wav", .bytes = wav + samples, .header = ""},
          {.name = "LVM", .file = "x.lvm", .bytes = lvm, .header = ""}};
}

}  // namespace powbench::host
