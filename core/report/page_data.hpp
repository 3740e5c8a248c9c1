// A recorded life in the binary that the replay page reads (docs/replay-page.md describes it):
//
//   "SOMASPG1"  u32 length  JSON header  blocks, one after the other
//
// A block is a column of all frames. What compresses badly is turned round first (differences, bits
// exclusive-or those of the same cell a frame before) and all columns are split into planes of
// first, second, ... bytes. Nothing is lost but the precision of grids and morphogens: a byte a
// square, from the least to the largest content of the grid over the life. Little-endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/recording/sink.hpp"

namespace somas::report {

/// A column of a page's recording while it grows.
class PageColumn {
 public:
  enum class Type : std::uint8_t { u8, u16, u32, f32 };
  enum class Encoding : std::uint8_t {
    plain,
    delta,  ///< the difference to the value `stride` places before
    cell,   ///< exclusive-or the same cell's a frame before
  };

  PageColumn(std::string name, Type type, Encoding encoding = Encoding::plain,
             std::uint32_t stride = 1)
      : name_(std::move(name)), type_(type), encoding_(encoding), stride_(stride) {}

  template <class Value>
  void add(Value value);
  template <class Value>
  void add_all(const std::vector<Value>& values) {
    for (const Value value : values) add(value);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] Type type() const { return type_; }
  [[nodiscard]] Encoding encoding() const { return encoding_; }
  [[nodiscard]] std::uint32_t stride() const { return stride_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size() / width(); }
  /// The encoded planes. `previous`: of each row, the row of the same cell a frame before, or -1.
  [[nodiscard]] std::string encode(const std::vector<std::int64_t>& previous) const;

 private:
  [[nodiscard]] std::size_t width() const {
    return type_ == Type::u8 ? 1 : type_ == Type::u16 ? 2 : 4;
  }
  [[nodiscard]] std::uint32_t load(std::size_t i) const;

  std::string name_;
  Type type_;
  Encoding encoding_;
  std::uint32_t stride_;
  std::vector<std::uint8_t> bytes_;
};

/// Words that the recording itself does not hold.
struct PageTitles {
  std::vector<std::string> changes{};  ///< what a what-if changed ("world.max_cells=10")
};

class PageData final : public recording::Sink {
 public:
  explicit PageData(PageTitles titles = {}) : titles_(std::move(titles)) {}

  void begin(const recording::Header& header) override;
  void event(const recording::Event& event) override;
  void summary(const recording::Summary& summary) override;
  void frame(const recording::Frame& frame) override;
  void finish(const recording::Ending& ending) override;

  /// The bytes, after finish. Throws std::logic_error before.
  [[nodiscard]] std::string bytes() const;
  [[nodiscard]] std::size_t frames() const { return frames_; }

 private:
  /// A grid of the header, or a morphogen of an organism.
  struct Field {
    std::string name, resource;
    recording::Grid grid;
    std::uint32_t organism = recording::none;  ///< of a morphogen
    std::vector<float> content{};              ///< of all frames with fields
  };

  void declare_cells();
  void declare_fields();
  void declare_summaries();
  void add_cells(const recording::Cells& cells);
  void add_tables(const std::vector<recording::TableRows>& tables);
  void add_fields(const recording::Frame& frame);
  void link_to_last_frame(const recording::Cells& cells);
  [[nodiscard]] std::string header(const std::vector<const PageColumn*>& columns) const;
  [[nodiscard]] PageColumn bytes_of(const Field& field, std::size_t index) const;
  [[nodiscard]] std::pair<float, float> range_of(const Field& field) const;

  PageTitles titles_;
  recording::Header header_;
  recording::Ending ending_;
  bool finished_ = false;
  std::size_t frames_ = 0, field_frames_ = 0;

  std::vector<PageColumn> frame_, cell_, values_, inputs_, outputs_, damage_, event_, summary_;
  struct DrawnTable {
    std::size_t index = 0, x = 0, y = 0;  ///< in the recording
    std::vector<PageColumn> columns{};    ///< starts of rows, x, y
  };
  std::vector<DrawnTable> tables_;
  std::vector<Field> fields_;
  std::vector<std::size_t> input_channels_;  ///< those that are no column of cells themselves

  std::vector<std::int64_t> previous_;
  std::vector<std::pair<std::uint16_t, std::uint32_t>> last_cells_;  ///< (organism, id)
  std::size_t last_begin_ = 0;
};

}  // namespace somas::report
