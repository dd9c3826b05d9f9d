// The contents of report.html: its data, safety against injected text, and (if Chromium is installed) its
// display.
#include "pipeline/report/report.hpp"
#include "tests/paths.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <set>

#include "pipeline/export/glb.hpp"
#include "pipeline/export/thumbnail.hpp"
#include "pipeline/files/whole_file.hpp"
#include "tests/pipeline/capsule_body.hpp"
#include "tests/pipeline/pendulum_efforts.hpp"

namespace borelli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* nasty = "Anna </script><b id=x>&\"quoted\" <!-- \xff \xe2\x80\xa8 µ";

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

/// The text of the script element with this id.
std::string script(const std::string& page, const std::string& id) {
  const auto tag = page.find("id=\"" + id + "\"");
  if (tag == std::string::npos) return {};
  const auto from = page.find('>', tag) + 1;
  return page.substr(from, page.find("</script>", from) - from);
}

std::string inflated(const std::string& base64, std::size_t expected) {
  std::string packed;
  std::uint32_t bits = 0;
  int held = 0;
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    if ((held += 6) >= 8) packed += static_cast<char>(bits >> (held -= 8) & 255);
  }
  std::string bytes(expected + 1, '\0');
  uLongf size = bytes.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  bytes.resize(size);
  return bytes;
}

struct Report : testing::Test {
  CapsuleScan scan = capsule_scan(capsule_grid(12));
  Landmarks joints = capsule_joints();
  Trajectory motion = capsule_motion();
  std::string body = *glb(capsule_meshes(), capsule_scan_poses(), motion);
  json run = {{"program", "borelli"},
              {"inputs", {{"path", "capsules.nii.gz"}}},
              {"stages",
               {{{"stage", "segmentation"},
                 {"seconds", 1.5},
                 {"peak_memory_mib", 300},
                 {"warnings", {"The left foot is cut off by the scan <i>."}}},
                {{"stage", "inertia"}, {"seconds", 0.25}, {"peak_memory_mib", 120}}}}};

  ReportInputs inputs() {
    ReportInputs in;
    in.subject = nasty;
    in.grey = &scan.grey;
    in.labels = &scan.labels;
    in.landmarks = &joints;
    in.table = capsule_table();
    in.trajectory = &motion;
    in.glb = body;
    in.run = run;
    in.files = {{"inertia/table.csv", 1234}, {"body.glb", body.size()}, {"mesh/head.stl", 99}};
    return in;
  }
  std::string page(const ReportInputs& in) {
    const auto made = report_page(in);
    EXPECT_TRUE(made) << made.error().message();
    return *made;
  }
};

TEST_F(Report, LoadsNothingFromOutside) {
  const std::string text = page(inputs());
  EXPECT_NE(text.find("default-src 'none'"), std::string::npos);
  // outside scripts and styles, no address except the empty icon's; no script with a source
  std::string outside;
  for (std::size_t at = 0; at < text.size();) {
    const auto next = std::min(text.find("<script", at), text.find("<style", at));
    outside += text.substr(at, next == std::string::npos ? next : next - at);
    if (next == std::string::npos) break;
    at = text.find(text.compare(next, 7, "<script") == 0 ? "</script>" : "</style>", next);
  }
  EXPECT_EQ(outside.find("://"), std::string::npos);
  EXPECT_EQ(count(outside, "href="), 1u);
  EXPECT_NE(outside.find("href=\"data:,\""), std::string::npos);
  EXPECT_EQ(count(text, "<script src"), 0u);
  const auto style = text.substr(text.find("<style>"), text.find("</style>") - text.find("<style>"));
  EXPECT_EQ(style.find("url("), std::string::npos);
  EXPECT_EQ(style.find("@import"), std::string::npos);
}

TEST_F(Report, EscapesUserText) {
  const std::string text = page(inputs());
  EXPECT_EQ(count(text, "<script"), count(text, "</script>"));
  EXPECT_EQ(count(text, "<script"), 6u);  // the data, three blocks, uPlot, the program
  EXPECT_EQ(text.find("<b id=x>"), std::string::npos);
  EXPECT_NE(text.find("<title>Anna &lt;/script&gt;&lt;b id=x&gt;&amp;&quot;quoted&quot;"), std::string::npos);
  const json data = json::parse(script(text, "report"));
  EXPECT_EQ(data["subject"], "Anna </script><b id=x>&\"quoted\" <!-- \xef\xbf\xbd \xe2\x80\xa8 µ");
  EXPECT_EQ(data["run"], run);
}

TEST_F(Report, ContainsItsInputs) {
  const std::string text = page(inputs());
  const json data = json::parse(script(text, "report"));
  for (std::size_t label = 1; label < parts.size(); ++label) {
    EXPECT_EQ(data["parts"][label - 1]["name"], parts[label].name);
    EXPECT_EQ(data["parts"][label - 1]["label"], label);
  }
  EXPECT_EQ(data["table"], capsule_table());
  EXPECT_EQ(data["joints"].size(), 15u);
  EXPECT_EQ(data["motion"]["times"].size(), motion.times.size());
  EXPECT_EQ(data["motion"]["kinetic"][7], motion.kinetic[7]);
  EXPECT_EQ(data["motion"]["certificate"]["trusted"], true);
  EXPECT_EQ(data["source"]["quantity"], "hu");
  EXPECT_EQ(inflated(script(text, "block-body"), body.size()), body);
  const Thumbnail copy = thumbnail(&scan.grey, &scan.labels);
  EXPECT_EQ(data["volume"]["size"], json(copy.size));
  const auto labels = inflated(script(text, "block-labels"), copy.labels.size());
  EXPECT_TRUE(std::equal(labels.begin(), labels.end(), copy.labels.begin(), copy.labels.end(),
                         [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }));
  EXPECT_EQ(inflated(script(text, "block-grey"), copy.grey.size()).size(), copy.grey.size());
}

TEST_F(Report, CountsGreyValues) {
  const json counts = json::parse(script(page(inputs()), "report"))["histogram"];
  const auto at = [&](const char* which, int value) -> std::size_t {
    return counts[which]
                 [static_cast<std::size_t>((value - counts["low"].get<int>()) / counts["width"].get<int>())];
  };
  // values are 40 in the capsules, 700 in their bones and -1000 outside
  std::map<int, std::size_t> voxels;
  for (const auto value : scan.grey.voxels) ++voxels[value];
  for (const int value : {-1000, 40, 700}) EXPECT_EQ(at("all", value), voxels[value]) << value;
  EXPECT_EQ(at("body", -1000), 0u);
  EXPECT_EQ(at("body", 40), voxels[40]);
  EXPECT_EQ(at("body", 700), voxels[700]);
  EXPECT_EQ(counts["tissues"][3], (json{{"name", "soft tissue"}, {"to", 160}}));
  scan.grey.quantity = Quantity::mr;  // MR values do not identify tissues
  EXPECT_TRUE(json::parse(script(page(inputs()), "report"))["histogram"]["tissues"].empty());
}

TEST_F(Report, DrawsThePlanesOfTheUsedConvention) {
  const auto cuts_after = [&](const char* convention) {
    ReportInputs in = inputs();
    in.segmentation = {{"convention", convention}};
    return json::parse(script(page(in), "report"))["cuts"];
  };
  const auto joints_of = [](const json& cuts) {
    std::set<std::string> names;
    for (const auto& line : cuts["lines"]) names.insert(line["joint"]);
    return names;
  };
  // the left thigh's label ends at its capsule's top, 850 + 72 mm; Dempster's plane passes through the joint
  // centre, de Leva's through the ASIS, which these landmarks lack
  joints["hip_left"].point = {85, 0, 918};
  EXPECT_EQ(joints_of(cuts_after("dempster")).count("hip_left"), 1u);
  EXPECT_EQ(joints_of(cuts_after("dempster")).count("elbow_left"), 1u);
  EXPECT_EQ(joints_of(cuts_after("deleva1996")).count("hip_left"), 0u);
  EXPECT_EQ(joints_of(cuts_after("deleva1996")).count("elbow_left"), 1u);
  EXPECT_EQ(cuts_after("dempster")["convention"], "dempster");
  EXPECT_EQ(cuts_after("bone"), (json{{"convention", "bone"}, {"lines", json::array()}}));
  EXPECT_TRUE(cuts_after("after my own head").is_null());
}

TEST_F(Report, ThinsLongMotionsForTheCurves) {
  motion = capsule_motion(20'000);
  const json data = json::parse(script(page(inputs()), "report"));
  EXPECT_LE(data["motion"]["times"].size(), 1502u);
  EXPECT_GE(data["motion"]["times"].size(), 1400u);
  EXPECT_EQ(data["motion"]["times"].back(), motion.times.back());
}

TEST_F(Report, NeedsFewInputs) {
  ReportInputs in;
  in.subject = "nothing yet";
  const json data = json::parse(script(page(in), "report"));
  EXPECT_TRUE(data["table"].is_null());
  EXPECT_FALSE(data.contains("motion"));
  in.labels = &scan.labels;
  EXPECT_EQ(json::parse(script(page(in), "report"))["source"]["quantity"], "labels");
}

TEST_F(Report, ShowsJointMomentsWithoutJavaScript) {
  const std::string without = page(inputs());
  ReportInputs in = inputs();
  in.efforts = test::pendulum_efforts(nasty);
  const std::string text = page(in);
  const auto main = text.find("<main"), end = text.find("</main>");
  const auto section = text.find("<section id=\"moments\"");
  EXPECT_LT(text.find("</noscript>", main), section);
  EXPECT_LT(section, end);
  EXPECT_EQ(count(text, "<script"), 6u);
  EXPECT_EQ(json::parse(script(text, "report"))["efforts"]["coordinates"].size(), 5u);
  EXPECT_FALSE(json::parse(script(without, "report")).contains("efforts"));
  EXPECT_EQ(without.find("id=\"moments\""), std::string::npos);
}

TEST_F(Report, RefusesDamagedEfforts) {
  ReportInputs in = inputs();
  in.efforts = {{"times", json::array()}};
  const auto made = report_page(in);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().where, "motion/efforts.json");
}

// Opens the page in headless Chromium: report_page_check.py checks it.
TEST_F(Report, DrawsItselfInABrowser) {
  if (std::system("python3 --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs python3";
  if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "needs chromium";
  const auto folder = fs::path(testing::TempDir()) / ("report_test_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  motion.multiplier_names = {"grip[0]", "grip[1]"};
  motion.multipliers = Rows::Constant(std::ssize(motion.times), 2, 5);
  joints["hip_left"].radius = 25;
  ReportInputs full = inputs();
  for (json& part : full.table["parts"])
    part["deviations"] = {{"mass_kg", {{"total", 0.25}}}, {"mass_pct", {{"total", 0.5}}}};
  ASSERT_TRUE(write_report(full, folder / "full.html"));
  ReportInputs little;
  little.subject = "little";
  little.labels = &scan.labels;
  ASSERT_TRUE(write_report(little, folder / "little.html"));
  const auto check = [](const std::string& words) {
    return std::system(("python3 -B " + test::source_folder() + "/tests/pipeline/" + words).c_str());
  };
  EXPECT_EQ(check("report_page_check.py " + (folder / "full.html").string() + " " +
                  (folder / "little.html").string()),
            0);
  full.efforts = test::pendulum_efforts("swing.trc", motion.times[0]);
  ASSERT_TRUE(write_report(full, folder / "moments.html"));
  EXPECT_EQ(check("report_moments_check.py " + (folder / "moments.html").string()), 0);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace borelli
