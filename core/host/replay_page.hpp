// replay --html: what the page shows, and the second life beside it.
#pragma once

#include "core/host/commands.hpp"
#include "core/report/page_data.hpp"
#include "core/run/replay.hpp"

namespace somas::host {

class ReplayPage {
 public:
  /// Throws run::UsageError for a comparison with a run that is not there. `command` must outlive
  /// this.
  explicit ReplayPage(const ReplayCommand& command);

  /// Receives the life that is replayed, or read.
  [[nodiscard]] run::Recipient life() { return recipient(life_); }

  /// Replays or reads the second life, if there is one, and writes the page. False if the second
  /// life should have reproduced its record and did not. Throws as run::replay and recording::read
  /// do, and run::WriteError.
  [[nodiscard]] bool write(run::Terminal& terminal);

 private:
  /// Whose the second life is.
  struct Other {
    std::filesystem::path run;  ///< or a recording
    std::optional<std::uint64_t> generation;
    std::uint32_t population = 1;
  };
  [[nodiscard]] std::optional<Other> other() const;
  [[nodiscard]] run::Recipient recipient(report::PageData& life) const;
  [[nodiscard]] bool replay(const Other& other, report::PageData& life, run::Terminal& terminal);

  const ReplayCommand& command_;
  std::optional<Other> other_;
  report::PageData life_;
};

}  // namespace somas::host
