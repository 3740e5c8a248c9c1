/// @file
/// What the checks share: the list of failures, threads that hand on exceptions, plain bytes.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <vector>

/// The conformance kit; see testing.hpp.
namespace somas::testing {

/// One readable sentence a broken promise; empty: the plugin keeps the contract.
using Failures = std::vector<std::string>;

/// A saved world.
using Bytes = std::vector<std::uint8_t>;

/// One promise of the contract, looked at by itself.
struct Check {
  std::string law;     ///< "saved in mid-life"; several checks may be of one law
  std::string name;    ///< how a failure begins: "saved before step 10, restored to a new instance"
  std::string remedy;  ///< what an author can do about it
  std::function<void()> body;  ///< throws what is wrong; any number of times, in any order
  /// Laws without which this one says nothing.
  std::vector<std::string> needs{};
  /// Checks with the same scope make no sense when this one fails.
  bool first = false;
  std::string scope{};
};

/// In the order in which they are told.
using Checks = std::vector<Check>;

namespace detail {

/// The shortest decimal that reads back exactly, whatever the locale.
inline std::string text_of(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

/// Runs `body`; an exception becomes a failure of `check`. Whether there was none.
template <class Body>
bool attempt(Failures& failures, const std::string& check, Body&& body) {
  try {
    body();
    return true;
  } catch (const std::exception& error) {
    failures.push_back(check + ": " + error.what());
  } catch (...) {
    failures.push_back(check + ": an exception that is no std::exception");
  }
  return false;
}

/// All checks in order, but for those that make no sense after a failure.
inline Failures run(const Checks& checks) {
  Failures failures;
  std::vector<std::string> ended;
  for (const Check& check : checks) {
    if (std::find(ended.begin(), ended.end(), check.scope) != ended.end()) continue;
    if (!attempt(failures, check.name, check.body) && check.first) ended.push_back(check.scope);
  }
  return failures;
}

/// Calls body(0), ..., body(count - 1), each on a new thread, all at once; the first exception is
/// thrown again here.
template <class Body>
void on_threads(std::size_t count, Body&& body) {
  std::vector<std::exception_ptr> errors(count);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < count; ++i)
    threads.emplace_back([&, i] {
      try {
        body(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

/// Appends plain values and lists of them.
class ByteWriter {
 public:
  template <class T>
  void value(const T& plain) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* first = reinterpret_cast<const std::uint8_t*>(&plain);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  template <class T>
  void list(const std::vector<T>& items) {
    value(static_cast<std::uint64_t>(items.size()));
    for (const T& item : items) value(item);
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

/// Reads what a ByteWriter wrote; throws std::runtime_error when the bytes end early.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  template <class T>
  void value(T& plain) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (left_.size() < sizeof(T)) throw std::runtime_error("the saved bytes end early");
    std::memcpy(&plain, left_.data(), sizeof(T));
    left_ = left_.subspan(sizeof(T));
  }
  template <class T>
  void list(std::vector<T>& items) {
    std::uint64_t count = 0;
    value(count);
    if (count > left_.size() / sizeof(T)) throw std::runtime_error("the saved bytes end early");
    items.resize(count);
    for (T& item : items) value(item);
  }
  [[nodiscard]] bool at_end() const { return left_.empty(); }

 private:
  std::span<const std::uint8_t> left_;
};

/// FNV-1a over the bytes of plain values.
class Hash {
 public:
  template <class T>
  void add(const T& plain) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
    std::uint8_t bytes[sizeof(T)];
    std::memcpy(bytes, &plain, sizeof(T));
    for (const std::uint8_t byte : bytes) {
      value_ ^= byte;
      value_ *= 0x100000001B3ull;
    }
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ull;
};

}  // namespace detail
}  // namespace somas::testing
