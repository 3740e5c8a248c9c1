// A thin layer over the C library HDF5: handles that close themselves, errors that are exceptions,
// and columns that grow. For the files of this room alone.
//
// The library must not be called by two threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace somas::recording::hdf5 {

/// What the library says, innermost reason last.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The library's hid_t.
using Id = std::int64_t;

/// Owns one of the library's objects.
class Handle {
 public:
  using Close = int (*)(Id);

  Handle() = default;
  Handle(Id id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(std::exchange(other.close_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (close_ != nullptr && id_ >= 0) close_(id_);
  }
  [[nodiscard]] Id get() const { return id_; }

 private:
  Id id_ = -1;
  Close close_ = nullptr;
};

/// Numbers that can be stored.
enum class Type { u8, u16, u32, u64, f32, f64 };
template <class T>
inline constexpr Type type_of = Type::f64;
template <>
inline constexpr Type type_of<std::uint8_t> = Type::u8;
template <>
inline constexpr Type type_of<std::uint16_t> = Type::u16;
template <>
inline constexpr Type type_of<std::uint32_t> = Type::u32;
template <>
inline constexpr Type type_of<std::uint64_t> = Type::u64;
template <>
inline constexpr Type type_of<float> = Type::f32;

using Shape = std::vector<std::uint64_t>;

// ---- files and groups ---------------------------------------------------------------------------

/// A new file in memory.
[[nodiscard]] Handle create_in_memory();
/// The bytes of a file in memory, as they would stand on disk.
[[nodiscard]] std::vector<std::byte> image_of(const Handle& file);
/// For reading.
[[nodiscard]] Handle open_file(const std::filesystem::path& path);

[[nodiscard]] Handle create_group(const Handle& in, const std::string& name);
[[nodiscard]] Handle open_group(const Handle& in, const std::string& name);

/// A name that can stand for an object: a slash would be a path.
[[nodiscard]] std::string object_name(std::string_view name);

// ---- small things -------------------------------------------------------------------------------

void write_attribute(const Handle& of, const std::string& name, std::string_view text);
void write_attribute(const Handle& of, const std::string& name, std::uint64_t value);
void write_attribute(const Handle& of, const std::string& name, double value);
[[nodiscard]] bool has_attribute(const Handle& of, const std::string& name);
[[nodiscard]] std::string read_text_attribute(const Handle& of, const std::string& name);
[[nodiscard]] std::uint64_t read_whole_attribute(const Handle& of, const std::string& name);
[[nodiscard]] double read_number_attribute(const Handle& of, const std::string& name);

/// A text of any length, and a list of texts.
void write_text(const Handle& in, const std::string& name, std::string_view text);
void write_texts(const Handle& in, const std::string& name, std::span<const std::string> texts);
[[nodiscard]] std::string read_text(const Handle& in, const std::string& name);
[[nodiscard]] std::vector<std::string> read_texts(const Handle& in, const std::string& name);

// ---- columns ------------------------------------------------------------------------------------

/// A data set that grows along its first dimension, shuffled and deflated. Its rows have the shape
/// `row` (empty: single numbers).
class RawColumn {
 public:
  RawColumn(const Handle& in, const std::string& name, Type type, const Shape& row);
  void append(const void* values, std::size_t count);  ///< whole rows
  void flush();

 private:
  void write_chunk(const std::byte* rows, std::uint64_t count);
  void grow_to(std::uint64_t rows);

  Handle set_;
  Type type_;
  Shape row_;
  std::size_t row_numbers_ = 1, row_bytes_ = 0, chunk_bytes_ = 0;
  std::uint64_t chunk_rows_ = 1, rows_ = 0;
  std::vector<std::byte> waiting_;
};

template <class T>
class Column {
 public:
  Column(const Handle& in, const std::string& name, const Shape& row = {})
      : raw_(in, name, type_of<T>, row) {}
  void add(const T& value) { raw_.append(&value, 1); }
  void add(std::span<const T> values) { raw_.append(values.data(), values.size()); }
  /// `count` rows one after another.
  void add_rows(const T* numbers, std::size_t count) { raw_.append(numbers, count); }
  void flush() { raw_.flush(); }

 private:
  RawColumn raw_;
};

/// A column that does not grow.
void write_numbers(const Handle& in, const std::string& name, Type type, const void* values,
                   std::size_t count);
template <class T>
void write_column(const Handle& in, const std::string& name, std::span<const T> values) {
  write_numbers(in, name, type_of<T>, values.data(), values.size());
}

/// A column for reading.
class RawReader {
 public:
  RawReader(const Handle& in, const std::string& name, Type type);
  [[nodiscard]] const Shape& shape() const { return shape_; }
  void read(std::uint64_t first, std::uint64_t count, void* values) const;  ///< rows

 private:
  Handle set_;
  std::string name_;
  Type type_;
  Shape shape_;
};

template <class T>
class Reader {
 public:
  Reader(const Handle& in, const std::string& name) : raw_(in, name, type_of<T>) {}
  [[nodiscard]] const Shape& shape() const { return raw_.shape(); }
  [[nodiscard]] std::uint64_t rows() const { return shape()[0]; }
  /// Numbers in a row.
  [[nodiscard]] std::uint64_t width() const {
    std::uint64_t numbers = 1;
    for (std::size_t d = 1; d < shape().size(); ++d) numbers *= shape()[d];
    return numbers;
  }
  [[nodiscard]] std::vector<T> rows(std::uint64_t first, std::uint64_t count) const {
    std::vector<T> values(count * width());
    raw_.read(first, count, values.data());
    return values;
  }
  [[nodiscard]] std::vector<T> all() const { return rows(0, rows()); }

 private:
  RawReader raw_;
};

template <class T>
[[nodiscard]] std::vector<T> read_column(const Handle& in, const std::string& name) {
  return Reader<T>(in, name).all();
}

}  // namespace somas::recording::hdf5
