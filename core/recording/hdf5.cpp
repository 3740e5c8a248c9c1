#include "core/recording/hdf5.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <hdf5.h>
#include <libdeflate.h>
#include <memory>
#include <new>

namespace somas::recording::hdf5 {
namespace {

static_assert(sizeof(Id) == sizeof(hid_t));

/// Large enough to compress well, small enough for the library's cache of a megabyte a data set.
constexpr std::size_t chunk_target = std::size_t{1} << 17;
constexpr unsigned deflate_level = 1;
constexpr double most_numbers = 1e10;

/// In the format of zlib, as the library's own filter reads it.
std::vector<std::byte> deflated(const std::vector<std::byte>& bytes) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(deflate_level), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::vector<std::byte> packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
  packed.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                         packed.data(), packed.size()));
  return packed;
}

/// The first call of the library; it would print to the standard error otherwise.
void be_quiet() {
  static const bool quiet = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  (void)quiet;
}

herr_t innermost(unsigned, const H5E_error2_t* error, void* text) {
  *static_cast<std::string*>(text) = error->desc != nullptr ? error->desc : "";
  return 0;
}

[[noreturn]] void fail(const std::string& what) {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, innermost, &reason);
  throw Error(reason.empty() ? what : what + ": " + reason);
}

template <class Result>
Result checked(Result result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}

int close_file(Id id) { return H5Fclose(id); }
int close_group(Id id) { return H5Gclose(id); }
int close_set(Id id) { return H5Dclose(id); }
int close_space(Id id) { return H5Sclose(id); }
int close_type(Id id) { return H5Tclose(id); }
int close_list(Id id) { return H5Pclose(id); }
int close_attribute(Id id) { return H5Aclose(id); }

hid_t stored(Type type) {
  switch (type) {
    case Type::u8:
      return H5T_STD_U8LE;
    case Type::u16:
      return H5T_STD_U16LE;
    case Type::u32:
      return H5T_STD_U32LE;
    case Type::u64:
      return H5T_STD_U64LE;
    case Type::f32:
      return H5T_IEEE_F32LE;
    default:
      return H5T_IEEE_F64LE;
  }
}

hid_t native(Type type) {
  switch (type) {
    case Type::u8:
      return H5T_NATIVE_UINT8;
    case Type::u16:
      return H5T_NATIVE_UINT16;
    case Type::u32:
      return H5T_NATIVE_UINT32;
    case Type::u64:
      return H5T_NATIVE_UINT64;
    case Type::f32:
      return H5T_NATIVE_FLOAT;
    default:
      return H5T_NATIVE_DOUBLE;
  }
}

std::size_t size_of(Type type) { return H5Tget_size(native(type)); }

/// Of any length, in UTF-8.
Handle text_type() {
  Handle type(checked(H5Tcopy(H5T_C_S1), "type"), close_type);
  checked(H5Tset_size(type.get(), H5T_VARIABLE), "type");
  checked(H5Tset_cset(type.get(), H5T_CSET_UTF8), "type");
  return type;
}

Handle scalar_space() { return {checked(H5Screate(H5S_SCALAR), "space"), close_space}; }

/// No times in it: the same life makes the same bytes.
Handle creation_list() {
  Handle list(checked(H5Pcreate(H5P_DATASET_CREATE), "list"), close_list);
  checked(H5Pset_obj_track_times(list.get(), 0), "list");
  return list;
}

void write_any_attribute(const Handle& of, const std::string& name, hid_t type, hid_t memory,
                         const void* value) {
  const Handle space = scalar_space();
  const Handle attribute(
      checked(H5Acreate2(of.get(), name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
              name),
      close_attribute);
  checked(H5Awrite(attribute.get(), memory, value), name);
}

Handle open_attribute(const Handle& of, const std::string& name) {
  return {checked(H5Aopen(of.get(), name.c_str(), H5P_DEFAULT), "attribute '" + name + "'"),
          close_attribute};
}

void read_any_attribute(const Handle& of, const std::string& name, H5T_class_t kind, hid_t memory,
                        void* value) {
  const Handle attribute = open_attribute(of, name);
  const Handle type(checked(H5Aget_type(attribute.get()), name), close_type);
  const Handle space(checked(H5Aget_space(attribute.get()), name), close_space);
  if (H5Tget_class(type.get()) != kind || H5Sget_simple_extent_npoints(space.get()) != 1)
    throw Error("attribute '" + name + "' is not of its type");
  checked(H5Aread(attribute.get(), memory, value), "attribute '" + name + "'");
}

Handle open_set(const Handle& in, const std::string& name) {
  return {checked(H5Dopen2(in.get(), name.c_str(), H5P_DEFAULT), "data set '" + name + "'"),
          close_set};
}

Shape shape_of(const Handle& set, const std::string& name) {
  const Handle space(checked(H5Dget_space(set.get()), name), close_space);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) fail(name);
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr);
  return {sizes.begin(), sizes.end()};
}

/// Texts that the library allocated.
class Texts {
 public:
  Texts(const Handle& set, const std::string& name)
      : space_(checked(H5Dget_space(set.get()), name), close_space), type_(text_type()) {
    const Handle stored_type(checked(H5Dget_type(set.get()), name), close_type);
    const hssize_t count = H5Sget_simple_extent_npoints(space_.get());
    if (H5Tis_variable_str(stored_type.get()) <= 0 || count < 0 || count > 1'000'000)
      throw Error("data set '" + name + "' holds no texts");
    texts_.resize(static_cast<std::size_t>(count), nullptr);
    if (count > 0)
      checked(H5Dread(set.get(), type_.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, texts_.data()), name);
  }
  Texts(const Texts&) = delete;
  Texts& operator=(const Texts&) = delete;
  ~Texts() {
    if (!texts_.empty()) H5Dvlen_reclaim(type_.get(), space_.get(), H5P_DEFAULT, texts_.data());
  }
  [[nodiscard]] std::vector<std::string> copy() const {
    std::vector<std::string> copies;
    for (const char* text : texts_) copies.emplace_back(text != nullptr ? text : "");
    return copies;
  }

 private:
  Handle space_, type_;
  std::vector<char*> texts_;
};

void write_text_set(const Handle& in, const std::string& name, const Handle& space,
                    const std::vector<const char*>& texts) {
  const Handle type = text_type();
  const Handle list = creation_list();
  const Handle set(checked(H5Dcreate2(in.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT,
                                      list.get(), H5P_DEFAULT),
                           name),
                   close_set);
  if (texts.empty()) return;
  checked(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()), name);
}

}  // namespace

// ---- files and groups ---------------------------------------------------------------------------

Handle create_in_memory() {
  be_quiet();
  const Handle access(checked(H5Pcreate(H5P_FILE_ACCESS), "list"), close_list);
  checked(H5Pset_fapl_core(access.get(), std::size_t{1} << 22, 0), "memory");
  // Most data sets have few chunks: a small index of them, and small groups.
  const Handle creation(checked(H5Pcreate(H5P_FILE_CREATE), "list"), close_list);
  checked(H5Pset_istore_k(creation.get(), 4), "index");
  return {checked(H5Fcreate("recording", H5F_ACC_TRUNC, creation.get(), access.get()), "new file"),
          close_file};
}

std::vector<std::byte> image_of(const Handle& file) {
  checked(H5Fflush(file.get(), H5F_SCOPE_GLOBAL), "flush");
  const ssize_t size = checked(H5Fget_file_image(file.get(), nullptr, 0), "image");
  std::vector<std::byte> image(static_cast<std::size_t>(size));
  checked(H5Fget_file_image(file.get(), image.data(), image.size()), "image");
  return image;
}

Handle open_file(const std::filesystem::path& path) {
  be_quiet();
  const Handle access(checked(H5Pcreate(H5P_FILE_ACCESS), "list"), close_list);
  // Files are complete when they have their name, and some file systems have no locks.
  checked(H5Pset_file_locking(access.get(), 0, 1), "locking");
  const htri_t is_hdf5 = H5Fis_hdf5(path.c_str());
  if (is_hdf5 == 0) throw Error("not an HDF5 file");
  return {checked(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), "cannot be opened"),
          close_file};
}

Handle create_group(const Handle& in, const std::string& name) {
  return {checked(H5Gcreate2(in.get(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), name),
          close_group};
}

Handle open_group(const Handle& in, const std::string& name) {
  return {checked(H5Gopen2(in.get(), name.c_str(), H5P_DEFAULT), "group '" + name + "'"),
          close_group};
}

std::string object_name(std::string_view name) {
  std::string safe(name);
  std::replace(safe.begin(), safe.end(), '/', '_');
  return safe.empty() || safe == "." ? "_" : safe;
}

// ---- small things -------------------------------------------------------------------------------

void write_attribute(const Handle& of, const std::string& name, std::string_view text) {
  const std::string copy(text);
  const char* pointer = copy.c_str();
  const Handle type = text_type();
  write_any_attribute(of, name, type.get(), type.get(), &pointer);
}

void write_attribute(const Handle& of, const std::string& name, std::uint64_t value) {
  write_any_attribute(of, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

void write_attribute(const Handle& of, const std::string& name, double value) {
  write_any_attribute(of, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

bool has_attribute(const Handle& of, const std::string& name) {
  return H5Aexists(of.get(), name.c_str()) > 0;
}

std::string read_text_attribute(const Handle& of, const std::string& name) {
  const Handle attribute = open_attribute(of, name);
  const Handle stored_type(checked(H5Aget_type(attribute.get()), name), close_type);
  if (H5Tis_variable_str(stored_type.get()) <= 0)
    throw Error("attribute '" + name + "' is not of its type");
  char* text = nullptr;
  const Handle type = text_type();
  read_any_attribute(of, name, H5T_STRING, type.get(), &text);
  std::string copy(text != nullptr ? text : "");
  H5free_memory(text);
  return copy;
}

std::uint64_t read_whole_attribute(const Handle& of, const std::string& name) {
  std::uint64_t value = 0;
  read_any_attribute(of, name, H5T_INTEGER, H5T_NATIVE_UINT64, &value);
  return value;
}

double read_number_attribute(const Handle& of, const std::string& name) {
  double value = 0;
  read_any_attribute(of, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, &value);
  return value;
}

void write_text(const Handle& in, const std::string& name, std::string_view text) {
  const std::string copy(text);
  write_text_set(in, name, scalar_space(), {copy.c_str()});
}

void write_texts(const Handle& in, const std::string& name, std::span<const std::string> texts) {
  const hsize_t count = texts.size();
  const Handle space(checked(H5Screate_simple(1, &count, nullptr), name), close_space);
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  write_text_set(in, name, space, pointers);
}

std::string read_text(const Handle& in, const std::string& name) {
  const std::vector<std::string> texts = read_texts(in, name);
  if (texts.size() != 1) throw Error("data set '" + name + "' is not one text");
  return texts[0];
}

std::vector<std::string> read_texts(const Handle& in, const std::string& name) {
  const Handle set = open_set(in, name);
  return Texts(set, name).copy();
}

// ---- columns ------------------------------------------------------------------------------------

void write_numbers(const Handle& in, const std::string& name, Type type, const void* values,
                   std::size_t count) {
  const hsize_t size = count;
  const Handle space(checked(H5Screate_simple(1, &size, nullptr), name), close_space);
  const Handle list = creation_list();
  const Handle set(checked(H5Dcreate2(in.get(), name.c_str(), stored(type), space.get(),
                                      H5P_DEFAULT, list.get(), H5P_DEFAULT),
                           name),
                   close_set);
  if (count == 0) return;
  checked(H5Dwrite(set.get(), native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), name);
}

RawColumn::RawColumn(const Handle& in, const std::string& name, Type type, const Shape& row)
    : type_(type), row_(row) {
  for (const std::uint64_t size : row) row_numbers_ *= size;
  row_bytes_ = row_numbers_ * size_of(type);
  chunk_rows_ =
      std::clamp<std::uint64_t>(chunk_target / std::max<std::size_t>(1, row_bytes_), 1, 1u << 14);
  chunk_bytes_ = chunk_rows_ * row_bytes_;

  std::vector<hsize_t> now{0}, most{H5S_UNLIMITED}, chunk{chunk_rows_};
  for (const std::uint64_t size : row) {
    now.push_back(size);
    most.push_back(size);
    chunk.push_back(std::max<std::uint64_t>(1, size));
  }
  const auto rank = static_cast<int>(now.size());
  const Handle space(checked(H5Screate_simple(rank, now.data(), most.data()), name), close_space);
  const Handle list = creation_list();
  checked(H5Pset_chunk(list.get(), rank, chunk.data()), name);
  checked(H5Pset_shuffle(list.get()), name);
  checked(H5Pset_deflate(list.get(), deflate_level), name);
  set_ = {checked(H5Dcreate2(in.get(), name.c_str(), stored(type), space.get(), H5P_DEFAULT,
                             list.get(), H5P_DEFAULT),
                  name),
          close_set};
}

void RawColumn::append(const void* values, std::size_t count) {
  if (row_bytes_ == 0) {
    rows_ += count;
    return;
  }
  const auto* bytes = static_cast<const std::byte*>(values);
  waiting_.insert(waiting_.end(), bytes, bytes + count * row_bytes_);
  // Whole chunks only: each is compressed once.
  std::size_t written = 0;
  for (; waiting_.size() - written >= chunk_bytes_; written += chunk_bytes_)
    write_chunk(waiting_.data() + written, chunk_rows_);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(written));
}

void RawColumn::grow_to(std::uint64_t rows) {
  rows_ = rows;
  std::vector<hsize_t> size{rows_};
  size.insert(size.end(), row_.begin(), row_.end());
  checked(H5Dset_extent(set_.get(), size.data()), "growing");
}

// Past the library's own filters, which do the same with zlib in several times as long.
void RawColumn::write_chunk(const std::byte* rows, std::uint64_t count) {
  static_assert(std::endian::native == std::endian::little, "numbers are stored as they are");
  const std::size_t width = size_of(type_), numbers = chunk_bytes_ / width;
  std::vector<std::byte> shuffled(chunk_bytes_);
  for (std::size_t plane = 0; plane < width; ++plane)
    for (std::size_t i = 0; i < count * row_numbers_; ++i)
      shuffled[plane * numbers + i] = rows[i * width + plane];
  const std::vector<std::byte> packed = deflated(shuffled);

  std::vector<hsize_t> offset(row_.size() + 1, 0);
  offset[0] = rows_;
  grow_to(rows_ + count);
  checked(H5Dwrite_chunk(set_.get(), H5P_DEFAULT, 0, offset.data(), packed.size(), packed.data()),
          "writing");
}

void RawColumn::flush() {
  if (!waiting_.empty()) write_chunk(waiting_.data(), waiting_.size() / row_bytes_);
  waiting_.clear();
  if (row_bytes_ == 0) grow_to(rows_);
}

RawReader::RawReader(const Handle& in, const std::string& name, Type type)
    : set_(open_set(in, name)), name_(name), type_(type), shape_(shape_of(set_, name)) {
  const Handle kind(checked(H5Dget_type(set_.get()), name), close_type);
  const bool whole = type != Type::f32 && type != Type::f64;
  if (shape_.empty() || H5Tget_class(kind.get()) != (whole ? H5T_INTEGER : H5T_FLOAT))
    throw Error("data set '" + name + "' is not of its type");
  // A damaged file must not ask for more memory than there is.
  double numbers = 1;
  for (const std::uint64_t size : shape_) numbers *= static_cast<double>(size);
  if (numbers > most_numbers) throw Error("data set '" + name + "' is too large");
}

void RawReader::read(std::uint64_t first, std::uint64_t count, void* values) const {
  if (first > shape_[0] || count > shape_[0] - first)
    throw Error("data set '" + name_ + "' is too short");
  std::vector<hsize_t> start(shape_.size(), 0), block(shape_.begin(), shape_.end());
  start[0] = first;
  block[0] = count;
  if (std::find(block.begin(), block.end(), 0) != block.end()) return;
  const Handle space(checked(H5Dget_space(set_.get()), name_), close_space);
  checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, block.data(),
                              nullptr),
          name_);
  const Handle memory(
      checked(H5Screate_simple(static_cast<int>(block.size()), block.data(), nullptr), name_),
      close_space);
  checked(H5Dread(set_.get(), native(type_), memory.get(), space.get(), H5P_DEFAULT, values),
          "data set '" + name_ + "'");
}

}  // namespace somas::recording::hdf5
