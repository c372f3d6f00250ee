#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/system/program.h"

/// What people type wrong in their first days, and the sentence they get. Each ends with 2 (3 where a rig does not
/// answer) and leaves nothing behind.

using namespace powbench::test;
using Catch::Contains;

namespace {

struct Mistake {
  std::vector<std::string> words;
  const char* says;
  int status = 2;
};

struct BadFile {
  const char* text;
  const char* says;
};

const char* const good_plan = "angles_deg = [0, 60]\nrepeats = 1\n";

}  // namespace

TEST_CASE("mistakes on the command line", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", good_plan), text = folder.write("t.txt", "hello\n"),
                    empty = folder.write("e.db", ""), db = folder.file("lab.db"),
                    none = folder.file("none.toml");
  REQUIRE(run(folder, {"run", folder.write("one.toml", "angles_deg = [60]\nrepeats = 1\n"), "--rig",
                       "sim:", "--db", db})
              .status == 0);
  const std::string before = read_file(db);
  const std::vector<Mistake> mistakes{
      {{"reprot", "--db", db}, "no verb 'reprot'; did you mean 'powbench report'?"},
      {{"acquire", plan}, "did you mean 'powbench run'?"},
      {{"check", plan}, "did you mean 'powbench plan check'?"},
      {{"list"}, "did you mean 'powbench campaigns'?"},
      {{"record"}, "did you mean 'powbench run'?"},
      {{"abort"}, "did you mean 'powbench stop'?"},
      {{"oscilloscope"}, "did you mean 'powbench import'?"},
      {{"push"}, "did you mean 'powbench db push'?"},
      {{"plan", "chekc", plan}, "no verb 'plan chekc'; did you mean 'powbench plan check'?"},
      {{"xyzzy"}, "no verb 'xyzzy'; powbench --help lists them"},
      {{"export", "1", "--db", db, "-o", folder.file("x.wav")},
       "no format has files of that name; known: .csv"},
      {{"events", "1", "--db", db, "--campaign", "77"}, "shot 1 is of campaign 1; leave --campaign out"},
      {{"events", "/dev/null"}, "is no file but a pipe or a device"},
      {{"sweep", "--vary", "core.mass_g=150:250:5", "--vary", "core.mass_g=100:120:2"}, "is varied twice"},
      {{"sweep", "--best-angle", "--sensitivity"}, "--sensitivity and --best-angle: one of them"},
      {{"run", plan, "--rig", "sim:" + folder.write("odd.rig.toml", "sample_rate_hertz = 99999.9\n")},
       "odd.rig.toml: the rig's program would refuse this configuration: sample rates"},
      {{"run", plan, "--dry-run", "--rig",
        "sim:" + folder.write("low.rig.toml", "[electrical]\nvoltage_full_scale_V = 300\n")},
       "voltage_full_scale_V = 300, allowed 325.3 .. 10000"},
      {{"run", plan, "--rig",
        "sim:" + folder.write("weak.rig.toml", "[electrical]\ncurrent_full_scale_A = 1.6\n")},
       "[electrical] current_full_scale_A = 1.6, allowed 1.801 .. 393.2"},
      {{"run", plan, "--rig", "sim:" + folder.write("fine.rig.toml", "[laser]\nscale_um_per_count = 0.15\n")},
       "[laser] scale_um_per_count = 0.15, allowed 0.2442 .. "},
      {{"run"}, "plan is required"},
      {{"run", plan}, "no rig is named; --rig sim: is a simulated one"},
      {{"run", none, "--rig", "sim:"}, "none.toml: cannot be read"},
      {{"run", plan, "--rig", "sim"}, "unknown rig 'sim'; did you mean 'sim:'?"},
      {{"run", plan, "--rig", "192.0.2.1"}, "did you mean 'ip:192.0.2.1'?"},
      {{"run", plan, "--rig", "/dev/ttyACM0"}, "did you mean 'serial:/dev/ttyACM0'?"},
      {{"run", plan, "--rig", "sim:none.rig.toml"}, "none.rig.toml: cannot be read"},
      {{"run", plan, "--rig", "serial:/dev/ttyNONE"}, "is the cable in and the board powered?", 3},
      {{"run", plan, "--rig", "ip:127.0.0.200"},
       "nothing listens there; start the rig or correct the address",
       3},
      {{"run", plan, "--rig", "sim:", "--max-failures", "0"}, "not in range 1 to 1000000"},
      {{"run", plan, "--rig", "sim:", "--db", "/nonexistent/x.db"},
       "there is no folder /nonexistent; make it first"},
      {{"run", plan, "--rig", "sim:", "--db", "."}, "is a folder; name a file"},
      {{"plan", "check", "."}, "is a directory, not a file"},
      {{"plan", "template", "plna"}, "plna not in {plan,rig,specimen,solenoid,calibration}"},
      {{"report", "--db", folder.file("none.db")}, "no such store; check its name"},
      {{"report", "--db", text}, "a text file, not a powbench store"},
      {{"report", "--db", empty}, "no such store; check its name"},
      {{"report", "--db", db, "--campaign", "9"}, "no campaign 9"},
      {{"events", "999", "--db", db}, "no shot 999"},
      {{"events", folder.file("none.csv")}, "none.csv: cannot be read"},
      {{"events", "1", "--db", db, "--filter", "lowpas:2kHz"},
       "'lowpas:2kHz' is no filter; allowed none, plain, lowpass"},
      {{"events", "1", "--db", db, "--filter", "lowpass"}, "lowpass needs its frequency"},
      {{"events", "1", "--db", db, "--filter", "lowpass:2000"}, "'2000' has no unit (Hz, kHz)"},
      {{"events", "1", "--db", db, "--filter", "lowpass:2,5kHz"}, "'2,5kHz' is no frequency"},
      {{"events", "1", "--db", db, "--filter", "lowpass:5Hz"}, "'5Hz' is out of range; allowed"},
      {{"events", "1", "--db", db, "--filter", "lowpass:600kHz"}, "filter lowpass:600kHz refused: "},
      {{"events", "1", "--db", db, "--filter", "lowpass:1kHz"}, "allowed -20 dB or less"},
      {{"events", "1", "--db", db, "--filter", "bandstop:3.6..3.1kHz"}, "ends below its start"},
      {{"events", "1", "--db", db, "--filter", "bandstop:3.1kHz..3.11kHz"}, "is too narrow"},
      {{"events", "1", "--db", db, "--filter", "plain", "--phase", "causal"},
       "the plain filter is zero phase"},
      {{"events", "1", "--db", db, "--phase", "causal"}, "--phase: there is no filter"},
      {{"events", "1", "--db", db, "--filter", "lowpass:9kHz", "--phase", "late"}, "allowed zero or causal"},
      {{"events", "1", "--db", db, "--band", "3kHz"}, "--band: '3kHz' is no band; allowed LOW..HIGH"},
      {{"show", "abc", "--db", db}, "shot = abc"},
      {{"plot", "1", "-o", folder.file("x.gif"), "--db", db}, "a picture is .svg or .html"},
      {{"export", "1", "--to", "ods", "--db", db}, "ods not in {csv,nc,comtrade,xlsx,arrow,vtu,gltf}"},
      {{"compare", "1", "9", "--db", db}, "no campaign 9"},
      {{"annotate", "cutsomer", "x", "--db", db}, "did you mean 'customer'?"},
      {{"annotate", "customer", "--db", db}, "customer: the text is empty"},
      {{"sim", plan, "--db", folder.file("s.db"), "--accuracy", "0%"},
       "--accuracy = 0%, allowed 1e-6% .. 50%"},
      {{"sim", plan, "--db", folder.file("s.db"), "--fields", "tabel"},
       "allowed circuit, table, solved, ends"},
      {{"sim", plan, "--db", folder.file("s.db"), "--mechanics", "foo"},
       "allowed plant, rigid, modal, deformable"},
      {{"sweep", "--vary", "bridges.gap_mm=5:1", "--db", folder.file("w.db")}, "allowed ascending, within"},
      {{"sweep", "--vary", "gap=1:2", "--db", folder.file("w.db")},
       "section.key of the specimen file, such as core.mass_g"},
      {{"fit", "--free", "x=1:2"}, "not a number of a specimen"},
      {{"ladder", "--accuracy", "fast"}, "--accuracy = fast, allowed"},
      {{"ladder", "--judge", "100%"}, "--judge = 100%, allowed 1e-7% .. 50%"},
      {{"ladder", "--judge", "1%", "--accuracy", "1%"}, "without --accuracy, --table"},
      {{"ladder", "--judge", "1%", "--fit", folder.file("no.json")}, "no.json: cannot be read"},
      {{"ladder", "--angle", "10", "20"}, "--angle: one for a ladder; several with --judge"},
      {{"ladder", "--fit", "x.json"}, "--fit: for --judge only"},
      {{"field", "--steel", "iron"}, "built in are lamination"},
      {{"rig", "--listen", "300.1.1.1"}, "is no address; give one such as 127.0.0.7"},
      {{"rig", "--listen", "0.0.0.0"}, "add --open-to-network"},
      {{"calibrate", "sim:", "--id", "a", "--expires", "tomorrow"}, "as 2030-12-31"},
      {{"calibrate", "sim:", "--id", "a", "--expires", "2099-12-31", "-o", text},
       "t.txt: is there already and is not overwritten; name another file, or add --overwrite"},
      {{"calibrate", "ip:127.0.0.200", "--id", "a", "--expires", "2099-12-31", "-o", folder.file("c.toml")},
       "nothing listens there",
       3},
      {{"calibrate", "ip:127.0.0.200", "--id", "a", "--expires", "2099-12-31", "-o", text, "--overwrite"},
       "nothing listens there",
       3},
      {{"fit", "-o", text}, "is not overwritten; name another file, or add --overwrite"},
      {{"fit", "-o", none, "--fit", text}, "t.txt: is there already and is not overwritten"},
      {{"import", folder.write("w.csv", "time [s],a [V]\n0,1\n1e-3,2\n"), "--suggest", "-o", text},
       "is not overwritten; name another file, or add --overwrite"},
      {{"show", "1", "--campaign", "2", "--db", db},
       "--campaign 2: shot 1 is of campaign 1; leave --campaign out"},
      {{"plot", "1", "--campaign", "2", "--db", db}, "shot 1 is of campaign 1"},
      {{"report", "--db", db, "--pfd"},
       "powbench report: '--pfd' is no option of this verb; did you mean '--pdf'?"},
      {{"db", "check", db}, "is a word too many of this verb; name a store with --db "},
      {{"db", "merge", "-o", db}, "sources is required (stores to read"},
      {{"export", "1", "--db", db, "--to", "csv", "-o", "x.xlsx"},
       "a file of that name is xlsx; leave --to out"},
      {{"report", "x", "--db", db}, "'x' is a word too many of this verb; powbench report --help explains"},
      {{"plan", "check"}, "powbench plan check: plan is required (plan file"},
      {{"info", "teapot:"}, "unknown rig 'teapot:'; a rig is named like sim:"}};
  for (const Mistake& m : mistakes) {
    const Finished r = run(folder, m.words);
    INFO(m.words[0] << " " << (m.words.size() > 1 ? m.words[1] : "") << ": " << r.err);
    CHECK(r.status == m.status);
    CHECK_THAT(r.err, Contains(m.says));
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);  // one sentence
    CHECK(r.out.empty());
  }
  CHECK(read_file(db) == before);
  CHECK(read_file(text) == "hello\n");
  for (const char* left : {"s.db", "w.db", "x.gif", "c.toml", "none.toml"})
    CHECK_FALSE(std::filesystem::exists(folder.file(left)));
}

TEST_CASE("a file that is there already is replaced where that is asked for", "[system]") {
  Folder folder;
  const std::string specimen = folder.write("s.toml", "edited\n"), fit = folder.write("f.json", "{}\n");
  const Finished r = run(folder, {"fit", "--evaluations", "100", "--searches", "1", "--ensemble", "0", "-o",
                                  specimen, "--fit", fit, "--overwrite", "--progress", "none"});
  INFO(r.err);
  CHECK(r.status == 0);
  CHECK_THAT(read_file(specimen), Contains("[coil]"));
  CHECK_THAT(read_file(fit), Contains("\"kind\""));
}

TEST_CASE("mistakes in a plan", "[system]") {
  Folder folder;
  const BadFile plans[] = {
      {"angles_deg = 60\nrepeats = 1\n",
       "a.toml:1: angles_deg = 60: is a whole number, must be a list of numbers"},
      {"angles_deg = [60]\n", "repeats: is missing; allowed 1..10000"},
      {"angles_deg = [60, 60]\nrepeats = 1\n", "60 deg is listed twice"},
      {"angles_deg = [60]\nrepeats = \"3\"\n", "a.toml:2: repeats = \"3\": is text, must be a whole number"},
      {"angles_deg = [60]\nrepeats = 3.5\n", "must be a whole number"},
      {"angles_deg = [60]\nrepeats = 0\n", "out of range; allowed 1..10000"},
      {"angles_deg = [60]\nrepeats = 1\nhold_time_s = 0.1\n", "did you mean 'hold_time_ms'?"},
      {"angles_deg = [60]\nrepeats = 1\nhold_time_ms = 0.1\n", "out of range; allowed 1..10000 ms"},
      {"angles_deg = [60\nrepeats = 1\n", "a.toml:2: not TOML"},
      {"angles_deg = [60]\nrepeats = 1\norder = \"rand\"\n", "did you mean 'random'?"},
      {"angles_deg = [60]\nrepeats = 1\nspecimen = \"none.toml\"\n", "none.toml: cannot be read"},
      {"angles_deg = [60]\nrepeats = 1\n[limits.touch]\nmax_ms = 20\n", "did you mean 'limits.t_ct1'?"},
      {"angles_deg = [60]\nrepeats = 1\n[limits.t_ct1]\nmax = 20\n", "did you mean 'max_ms'?"},
      {"angles_deg = [60]\nrepeats = 1\n[limits]\nt_ct_bon_ms = 9\n",
       "unknown key; write [limits.t_ct_bon] and its keys below; known: min_ms, max_ms"},
      {"angles_deg = [60]\nrepeats = 1\n[limits.t_ct1]\nmin_ms = 20\nmax_ms = 10\n", "is above max_ms"},
      {"angles_deg = [60]\nrepeats = 1\nrepeats = 2\n", "given twice; keep one of the two lines"},
      {"angles_deg = { start = 0, stop = 180 }\nrepeats = 1\n", "'step' is missing"},
      {"angles_deg = { start = 0, stop = 180, step = -30 }\nrepeats = 1\n",
       "does not lead from 'start' to 'stop'"},
      {"angles_deg = []\nrepeats = 1\n", "is an empty list"},
      {"angles_deg = [0,1,2,3,4,5,6,7,8,9,10]\nrepeats = 10000\n", "gives 110000 shots with 11 angles"},
      {"angles_deg = [60]\nrepeats = 1\n[test]\ninstruments = \"laser\"\n",
       "must be a list of texts in quotes"},
      {"", "a.toml:1: angles_deg: is missing"}};
  for (const BadFile& p : plans) {
    const Finished r = run(folder, {"plan", "check", folder.write("a.toml", p.text)});
    INFO(p.text << r.err);
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains(p.says));
  }
}

TEST_CASE("mistakes in a waveform file", "[system]") {
  Folder folder;
  const std::string db = folder.file("i.db");
  const BadFile files[] = {
      {"time [s],pvdf_a [N]\n0,1\n0,2\n", "has 2 samples; allowed 8 or more"},
      {"time,pvdf_a\n0,1\n1,2\n", "has no unit; write it in brackets, as in `time [s]`"},
      {"time [s],pvdf_a [V]\n0,1\n1,2\n", "volts need a calibration; write [pvdf_a] gain_N_per_V"},
      {"a b c\n", "column 'a b c': is not known; allowed time, pvdf_a"},
      {"", "the file is empty; allowed a header line"}};
  for (const BadFile& f : files) {
    const Finished r = run(folder, {"import", folder.write("x.csv", f.text), "--db", db});
    INFO(f.text << r.err);
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains(f.says));
    CHECK_FALSE(std::filesystem::exists(db));
  }
}
