// A power cut at any moment: the log of all writes of a run is cut at the end of a flush (fsync),
// and what a disk may hold then is resumed. It always comes to the results of a run that was left
// in peace.
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <set>

#include <gmock/gmock.h>

#include "tests/core/host/toy_runs.hpp"
#include "tests/powercut/log.hpp"

namespace somas::test {
namespace {

namespace fs = std::filesystem;

struct Event {
  LogEntry entry;
  std::string path, data;
};

std::vector<Event> read_log(const fs::path& file) {
  const std::string bytes = run::read_file(file);
  std::vector<Event> events;
  for (std::size_t at = 0; at + sizeof(LogEntry) <= bytes.size();) {
    Event& event = events.emplace_back();
    std::memcpy(&event.entry, bytes.data() + at, sizeof(LogEntry));
    at += sizeof(LogEntry);
    event.path = bytes.substr(at, event.entry.path);
    at += event.entry.path;
    event.data = bytes.substr(at, event.entry.data);
    at += event.entry.data;
  }
  return events;
}

/// A file's content, wherever it is named.
using Content = std::shared_ptr<std::string>;

/// A file system in memory: what a disk holds.
class Disk {
 public:
  void apply(const Event& event) {
    const LogEntry& entry = event.entry;
    switch (entry.op) {
      case Op::create:
        names_[event.path] = contents_[entry.inode] = std::make_shared<std::string>();
        break;
      case Op::write: {
        std::string& text = *content(entry.inode);
        if (text.size() < entry.offset + event.data.size())
          text.resize(entry.offset + event.data.size());
        text.replace(entry.offset, event.data.size(), event.data);
        break;
      }
      case Op::truncate:
        content(entry.inode)->resize(entry.offset);
        break;
      case Op::rename:
        if (names_.contains(event.path)) names_[event.data] = names_[event.path];
        names_.erase(event.path);
        break;
      case Op::link:
        if (names_.contains(event.path)) names_[event.data] = names_[event.path];
        break;
      case Op::unlink:
        names_.erase(event.path);
        break;
      case Op::make_dir:
        directories_.insert(event.path);
        break;
      case Op::sync:
      case Op::sync_dir:
        break;
    }
  }

  void write_to(const fs::path& root) const {
    fs::create_directories(root);
    for (const std::string& name : directories_) fs::create_directories(root / name);
    for (const auto& [name, text] : names_) {
      // A file whose directory was lost is lost, too.
      std::error_code error;
      if (fs::is_directory((root / name).parent_path(), error)) run::write_file(root / name, *text);
    }
  }

 private:
  Content content(std::uint64_t inode) {
    Content& found = contents_[inode];
    if (!found) found = std::make_shared<std::string>();
    return found;
  }

  std::map<std::string, Content> names_;
  std::map<std::uint64_t, Content> contents_;
  std::set<std::string> directories_;
};

bool names_something(Op op) {
  return op == Op::create || op == Op::rename || op == Op::link || op == Op::unlink ||
         op == Op::make_dir;
}

std::string directory_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash);
}

/// What was flushed up to a moment: writes whose file, names whose directory was flushed later on.
std::vector<bool> flushed_by(const std::vector<Event>& events, std::size_t end) {
  std::vector<bool> flushed(end);
  std::set<std::uint64_t> files;
  std::set<std::string> directories;
  for (std::size_t i = end; i-- > 0;) {
    const LogEntry& entry = events[i].entry;
    if (entry.op == Op::sync) files.insert(entry.inode);
    if (entry.op == Op::sync_dir) directories.insert(events[i].path);
    if (names_something(entry.op))
      flushed[i] = directories.contains(directory_of(events[i].path));
    else
      flushed[i] = files.contains(entry.inode);
  }
  return flushed;
}

class PowerCut : public ToyRuns {
 protected:
  void record() {
    fs::create_directory(path("disk"));
    ::setenv("LD_PRELOAD", SOMAS_RECORDER, 1);
    ::setenv("SOMAS_RECORD_DIRECTORY", path("disk").c_str(), 1);
    ::setenv("SOMAS_RECORD_LOG", path("log").c_str(), 1);
    const int code = host({"toy.yaml", "--generations", "3", "--out", "disk/a"});
    for (const char* name : {"LD_PRELOAD", "SOMAS_RECORD_DIRECTORY", "SOMAS_RECORD_LOG"})
      ::unsetenv(name);
    ASSERT_EQ(code, 0) << err_;
    events_ = read_log(path("log"));
    reference_ = results_of(path("disk/a"));
  }

  /// Whether what is on the disk goes on to the reference.
  void expect_the_reference(const Disk& disk, const std::string& what) {
    fs::remove_all(path("cut"));
    disk.write_to(path("cut"));
    const bool begun = fs::exists(path("cut/a/manifest.json"));
    resumed_ += begun ? 1 : 0;
    const int code = begun ? host({"resume", "cut/a", "-q"})
                           : host({"toy.yaml", "--generations", "3", "--out", "cut/a", "-q"});
    ASSERT_EQ(code, 0) << what << ": " << err_;
    EXPECT_TRUE(results_of(path("cut/a")) == reference_) << what;
  }

  std::vector<Event> events_;
  std::map<std::string, std::string> reference_;
  int resumed_ = 0;
};

TEST_F(PowerCut, TheLogIsTheWholeRun) {
  record();
  Disk disk;
  for (const Event& event : events_) disk.apply(event);
  disk.write_to(path("copy"));
  EXPECT_TRUE(results_of(path("copy/a")) == reference_);
}

TEST_F(PowerCut, AtAnyFlushEndsInTheReference) {
  record();
  std::mt19937_64 random(1);
  int cuts = 0;
  for (std::size_t end = 1; end <= events_.size(); ++end) {
    const Op op = events_[end - 1].entry.op;
    if (op != Op::sync && op != Op::sync_dir) continue;
    const std::vector<bool> flushed = flushed_by(events_, end);
    // Nothing but what was flushed; all that was written; some of what was not flushed.
    Disk least, all, some;
    for (std::size_t i = 0; i < end; ++i) {
      if (flushed[i]) least.apply(events_[i]);
      all.apply(events_[i]);
      if (flushed[i] || random() % 2 == 0) some.apply(events_[i]);
    }
    const std::string where = "cut after event " + std::to_string(end);
    ++cuts;
    expect_the_reference(least, where + ", flushed only");
    // Every third: these two are alike most of the time.
    if (cuts % 3 == 0) expect_the_reference(some, where + ", some more");
    if (cuts % 3 == 1) expect_the_reference(all, where + ", all");
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(cuts, 20);
  EXPECT_GT(resumed_, cuts / 2);
}

}  // namespace
}  // namespace somas::test
