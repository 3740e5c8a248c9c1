// Tables of a run, read back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace somas::report {

/// Comma-separated values with a header line (RFC 4180).
class Table {
 public:
  /// Throws run::UsageError, with file and line, for a file that cannot be read or whose lines have
  /// not as many fields as its header.
  explicit Table(const std::filesystem::path& file);

  [[nodiscard]] std::size_t rows() const { return cells_.size(); }
  [[nodiscard]] bool has(const std::string& column) const;
  /// A field; throws run::UsageError for a column that is absent.
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const;
  /// The same as a number; throws run::UsageError for what is none.
  [[nodiscard]] double number(std::size_t row, const std::string& column) const;
  [[nodiscard]] std::uint64_t natural(std::size_t row, const std::string& column) const;

 private:
  [[nodiscard]] std::size_t index_of(const std::string& column) const;
  [[nodiscard]] std::string place(std::size_t row, const std::string& column) const;

  std::filesystem::path file_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> cells_;
};

/// What generations.csv says of one population, by generation from 0.
struct Generations {
  std::vector<double> best, upper_quartile, median, lower_quartile;
  std::vector<std::uint64_t> champion;  ///< ids
};
/// Throws run::UsageError for a run without a finished generation, or without that population.
[[nodiscard]] Generations read_generations(const std::filesystem::path& run,
                                           std::uint32_t population);

/// One that lived, as individuals.csv has it.
struct Ancestor {
  std::uint64_t id = 0, generation = 0;
  std::optional<std::uint64_t> first_parent, second_parent;
  std::string origin;
  double fitness = 0;
};

/// The line of first parents of `champion` in `generation`, oldest first; beside it the second
/// parents of its members, where they had one, and how many individuals of each generation are
/// ancestors of it by either parent.
struct Lineage {
  std::vector<Ancestor> line;
  std::vector<std::optional<Ancestor>> second_parents;  ///< of the member with the same index
  std::vector<double> ancestors;                        ///< by generation, from 0 to `generation`
};
/// Throws run::UsageError, saying where the line breaks off, if a parent is not on record.
[[nodiscard]] Lineage read_lineage(const std::filesystem::path& run, std::uint64_t generation,
                                   std::uint64_t champion, std::uint32_t population);

/// "survival": what fitness counts, from the manifest of a run.
[[nodiscard]] std::string objective_of(const std::filesystem::path& run);

/// Replicates that belong together.
struct Condition {
  std::string name;
  std::vector<std::filesystem::path> runs;
};
/// Whether a directory is a campaign: it has an index of its runs.
[[nodiscard]] bool is_campaign(const std::filesystem::path& directory);
/// The conditions of a campaign in the order of its index, with the runs that are complete; what is
/// left out goes into `warnings`. Throws run::UsageError where no run is complete.
[[nodiscard]] std::vector<Condition> conditions_of(const std::filesystem::path& campaign,
                                                   std::vector<std::string>& warnings);

/// The given run directories; for a directory that is none, the runs in it, by name. Throws
/// run::UsageError where there is neither.
[[nodiscard]] std::vector<std::filesystem::path> runs_in(
    const std::vector<std::filesystem::path>& given);

}  // namespace somas::report
