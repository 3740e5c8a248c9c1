// The log that recorder.cpp writes: what a process did to the files below a directory, in order.
#pragma once

#include <cstdint>

namespace somas::test {

enum class Op : std::uint8_t {
  create,    ///< path; a new inode
  write,     ///< inode, offset, data
  truncate,  ///< inode, size in offset
  sync,      ///< inode
  sync_dir,  ///< path
  rename,    ///< path, data: the new path
  link,      ///< path, data: the new path
  unlink,    ///< path
  make_dir,  ///< path
};

/// Followed by `path` and `data`, of these lengths.
struct LogEntry {
  Op op = Op::sync;
  std::uint64_t inode = 0;
  std::uint64_t offset = 0;
  std::uint32_t path = 0, data = 0;
};

}  // namespace somas::test
