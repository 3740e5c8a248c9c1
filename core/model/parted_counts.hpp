// A counting sort by a team: each part counts its items by key, then knows where each of them goes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/model/team.hpp"

namespace somas::model {

/// Calls work(part) for each part; several need a team.
template <class Work>
void run_parts(Team* team, unsigned parts, Work& work) {
  if (parts == 1) return work(0u);
  team->run(parts, work);
}

/// Items of a lower part come before those of a higher one with the same key, so items in order
/// that are cut into parts by place stay in order.
class PartedCounts {
 public:
  /// Room for so many keys of so many parts.
  void reset(unsigned parts, std::uint32_t keys) {
    parts_ = parts;
    keys_ = keys;
    if (counts_.size() < std::size_t{parts} * keys) counts_.resize(2 * std::size_t{parts} * keys);
    before_.resize(std::max<std::size_t>(before_.size(), parts));
  }
  /// A part's counts by key, all 0. By the thread that is to count.
  [[nodiscard]] std::uint32_t* begin(unsigned part) {
    std::fill_n(of(part), keys_, 0u);
    return of(part);
  }
  /// From counts to the places where a part's next item of each key goes. start[key] is the first
  /// place of a key, start[keys] is behind the last. Returns how many items there are.
  std::uint32_t to_places(Team* team, std::vector<std::uint32_t>& start) {
    start.resize(std::size_t{keys_} + 1);
    const auto sum_up = [&](unsigned part) { before_[part] = sum(stretch(keys_, part, parts_)); };
    run_parts(team, parts_, sum_up);
    std::uint32_t all = 0;
    for (unsigned part = 0; part < parts_; ++part) all += std::exchange(before_[part], all);
    const auto place = [&](unsigned part) {
      put_places(stretch(keys_, part, parts_), before_[part], start.data());
    };
    run_parts(team, parts_, place);
    start[keys_] = all;
    return all;
  }
  [[nodiscard]] std::uint32_t* of(unsigned part) {
    return counts_.data() + std::size_t{part} * keys_;
  }

 private:
  [[nodiscard]] std::uint32_t sum(Stretch keys) {
    std::uint32_t sum = 0;
    for (unsigned part = 0; part < parts_; ++part)
      for (std::uint32_t key = keys.begin; key < keys.end; ++key) sum += of(part)[key];
    return sum;
  }
  void put_places(Stretch keys, std::uint32_t next, std::uint32_t* start) {
    for (std::uint32_t key = keys.begin; key < keys.end; ++key) {
      start[key] = next;
      for (unsigned part = 0; part < parts_; ++part) next += std::exchange(of(part)[key], next);
    }
  }

  unsigned parts_ = 1;
  std::uint32_t keys_ = 0;
  std::vector<std::uint32_t> counts_;  ///< by part, then key
  std::vector<std::uint32_t> before_;  ///< of a part's stretch of the keys: items that come before
};

}  // namespace somas::model
