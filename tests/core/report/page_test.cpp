#include "core/report/page.hpp"

#include <bit>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/report/page_data.hpp"
#include "core/run/json.hpp"
#include "tests/core/recording/life.hpp"

namespace somas::report {
namespace {

using run::Json;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t prefix = 12;  // magic and length

std::uint32_t number_at(const std::string& bytes, std::size_t at, std::size_t width) {
  std::uint32_t value = 0;
  for (std::size_t b = 0; b < width; ++b)
    value |= std::uint32_t{static_cast<unsigned char>(bytes[at + b])} << (8 * b);
  return value;
}

Json header_of(const std::string& bytes) {
  return run::parse_json(bytes.substr(prefix, number_at(bytes, 8, 4)), "header");
}

/// Where each block begins, by name.
std::map<std::string, std::pair<std::size_t, Json>> blocks_of(const std::string& bytes) {
  std::map<std::string, std::pair<std::size_t, Json>> blocks;
  std::size_t at = prefix + number_at(bytes, 8, 4);
  const std::map<std::string, std::size_t> widths{{"u8", 1}, {"u16", 2}, {"u32", 4}, {"f32", 4}};
  const Json header = header_of(bytes);
  for (const Json& block : header["blocks"]) {
    blocks[block["name"].get<std::string>()] = {at, block};
    at += block["count"].get<std::size_t>() * widths.at(block["type"].get<std::string>());
  }
  blocks["end"] = {at, {}};
  return blocks;
}

/// A column of 32 bits, of plain values or differences.
std::vector<std::uint32_t> column(const std::string& bytes, const std::string& name) {
  const auto [at, block] = blocks_of(bytes).at(name);
  const std::size_t count = block["count"].get<std::size_t>();
  std::vector<std::uint32_t> values(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t b = 0; b < 4; ++b)
      values[i] |= number_at(bytes, at + b * count + i, 1) << (8 * b);
    if (block["encoding"] == "delta" && i > 0) values[i] += values[i - 1];
  }
  return values;
}

/// The busy life as a page holds it and as it was.
class PageDataOfALife : public testing::Test {
 protected:
  PageDataOfALife() {
    recording::test::set_up(bench_);
    life_ = recording::test::record(bench_);
    bytes_ = bytes_of({});
  }
  std::string bytes_of(PageTitles titles) const {
    PageData data(std::move(titles));
    data.begin(life_.header);
    for (const recording::Event& event : life_.events) data.event(event);
    for (const recording::Summary& summary : life_.summaries) data.summary(summary);
    for (const recording::Frame& frame : life_.frames) data.frame(frame);
    data.finish(life_.ending);
    return data.bytes();
  }

  model::test::Bench bench_;
  recording::Recording life_;
  std::string bytes_;
};

TEST_F(PageDataOfALife, IsAsLongAsItsHeaderSays) {
  EXPECT_EQ(bytes_.substr(0, 8), "SOMASPG1");
  EXPECT_EQ(blocks_of(bytes_).at("end").first, bytes_.size());
  EXPECT_EQ(bytes_, bytes_of({}));
}

TEST_F(PageDataOfALife, HoldsEveryCellOfEveryFrame) {
  std::vector<std::uint32_t> steps, rows{0}, ids;
  for (const recording::Frame& frame : life_.frames) {
    steps.push_back(static_cast<std::uint32_t>(frame.step));
    ids.insert(ids.end(), frame.cells.id.begin(), frame.cells.id.end());
    rows.push_back(static_cast<std::uint32_t>(ids.size()));
  }
  ASSERT_GT(ids.size(), 500u);
  EXPECT_EQ(column(bytes_, "frame.step"), steps);
  EXPECT_EQ(column(bytes_, "frame.rows"), rows);
  EXPECT_EQ(column(bytes_, "cell.id"), ids);
}

TEST_F(PageDataOfALife, KeepsTheBitsOfACellsNumbers) {
  // Columns of cells hold what changed since the frame before: here undone with maps.
  std::vector<std::uint32_t> coded = column(bytes_, "cell.x");
  std::map<std::pair<std::uint16_t, std::uint32_t>, std::uint32_t> last;
  std::size_t row = 0;
  for (const recording::Frame& frame : life_.frames) {
    std::map<std::pair<std::uint16_t, std::uint32_t>, std::uint32_t> now;
    for (std::size_t i = 0; i < frame.cells.size(); ++i, ++row) {
      const std::pair cell{frame.cells.organism[i], frame.cells.id[i]};
      const auto before = last.find(cell);
      now[cell] = coded.at(row) ^ (before == last.end() ? 0 : before->second);
      ASSERT_EQ(std::bit_cast<float>(now[cell]), frame.cells.x[i])
          << "step " << frame.step << ", cell " << cell.second;
    }
    last = std::move(now);
  }
  EXPECT_EQ(row, coded.size());
}

TEST_F(PageDataOfALife, HoldsEveryEventAndSummary) {
  std::vector<std::uint32_t> steps, cells, first_state;
  for (const recording::Event& event : life_.events) {
    steps.push_back(static_cast<std::uint32_t>(event.step));
    cells.push_back(event.cell);
  }
  for (const recording::Summary& summary : life_.summaries)
    first_state.push_back(summary.population[0]);
  ASSERT_GT(steps.size(), 10u);
  EXPECT_EQ(column(bytes_, "event.step"), steps);
  EXPECT_EQ(column(bytes_, "event.cell"), cells);
  EXPECT_EQ(column(bytes_, "summary.population.0.0"), first_state);
}

TEST_F(PageDataOfALife, ShowsGridsBetweenTheirLeastAndLargestContent) {
  const Json grids = header_of(bytes_)["grids"];
  // Grids of the world, and morphogens of both organisms.
  const std::size_t fields =
      life_.header.grids.size() + life_.header.organisms.size() * life_.header.morphogens.size();
  ASSERT_EQ(grids.size(), fields);
  ASSERT_FALSE(life_.header.grids.empty());
  const double low = grids[0]["low"].get<double>(), high = grids[0]["high"].get<double>();
  const auto [at, block] = blocks_of(bytes_).at("grid.0");
  const std::size_t squares = life_.header.grids[0].squares();
  std::vector<unsigned> last(squares, 0);
  std::size_t i = 0;
  for (const recording::Frame& frame : life_.frames) {
    if (!frame.has_fields) continue;
    for (std::size_t square = 0; square < squares; ++square, ++i) {
      last[square] = (last[square] + number_at(bytes_, at + i, 1)) & 255;
      ASSERT_NEAR(low + (high - low) * last[square] / 255, frame.grids[0][square],
                  (high - low) / 500);
    }
  }
  EXPECT_EQ(i, block["count"].get<std::size_t>());
}

TEST_F(PageDataOfALife, TellsWhatCellsCanBeColouredBy) {
  std::vector<std::string> names;
  const Json header = header_of(bytes_);
  for (const Json& attribute : header["attributes"]) {
    names.push_back(attribute["name"].get<std::string>());
    EXPECT_TRUE(blocks_of(bytes_).contains(attribute["column"].get<std::string>())) << names.back();
  }
  EXPECT_THAT(names, testing::IsSupersetOf(std::vector<std::string>{
                         "energy", "ambrosia", "pressure", "sensed morphogen.0", "output division",
                         "damage " + life_.header.hazards.at(0)}));
  // What is a column of cells is not told twice.
  EXPECT_THAT(names, Not(testing::Contains("sensed energy")));
}

TEST_F(PageDataOfALife, SaysWhatAWhatIfChanged) {
  EXPECT_EQ(header_of(bytes_of({.changes = {"world.max_cells=10"}}))["changes"][0],
            "world.max_cells=10");
}

TEST(PageData, IsNotToBeHadBeforeTheEnd) {
  EXPECT_THROW((void)PageData().bytes(), std::logic_error);
}

TEST(Page, HoldsTheLivesInOrderAndIsOtherwiseTheTemplate) {
  const std::string page = build_page(std::vector<std::string>{"one life", "and another"});
  const std::regex life(
      "<script type=\"application/x-somas-recording\">([A-Za-z0-9+/=]*)</script>\n");
  std::vector<std::string> found;
  for (std::sregex_iterator it(page.begin(), page.end(), life), end; it != end; ++it)
    found.push_back((*it)[1]);
  ASSERT_EQ(found.size(), 2u);
  // gzip's magic in base64, and lengths that are whole groups of four.
  for (const std::string& text : found) {
    EXPECT_THAT(text, testing::StartsWith("H4sI"));
    EXPECT_EQ(text.size() % 4, 0u);
  }
  EXPECT_NE(found[0], found[1]);
  EXPECT_EQ(std::regex_replace(page, life, "").size() + std::string("<!--recordings-->").size(),
            page_template().size());
  EXPECT_EQ(page, build_page(std::vector<std::string>{"one life", "and another"}));
}

TEST(Page, ForbidsItselfTheNetwork) {
  const std::string page(page_template());
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, testing::StartsWith("<!doctype html>"));
  // No file beside it: whatever has a source or a reference is in the page.
  const std::regex reference("<(script|link|img)[^>]*(src|href)=\"(?!data:)");
  EXPECT_FALSE(std::regex_search(page, reference));
}

}  // namespace
}  // namespace somas::report
