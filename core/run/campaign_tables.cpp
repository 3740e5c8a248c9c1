#include "core/run/campaign_tables.hpp"

#include <algorithm>

#include "core/evolution/ranking.hpp"
#include "core/run/csv.hpp"
#include "core/run/files.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/store.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

const char* name_of(RunStatus status) {
  switch (status) {
    case RunStatus::running:
      return "running";
    case RunStatus::complete:
      return "complete";
    case RunStatus::stopped:
      return "stopped";
    case RunStatus::failed:
      return "failed";
    case RunStatus::waiting:
      break;
  }
  return "waiting";
}

bool says_complete(const fs::path& run) {
  const fs::path file = run / "summary.json";
  std::error_code error;
  if (!fs::exists(file, error)) return false;
  const Json json = parse_json(read_file(file), file.string());
  return JsonView(json, file.string()).member("status").text() == "complete";
}

/// A reason is one line.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// The middle and the spread of a number over runs; empty fields without any.
void add_statistics(CsvLine& line, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  if (values.empty()) {
    for (int i = 0; i < 6; ++i) line.add("");
    return;
  }
  const double lower = evolution::quantile(values, 0.25), upper = evolution::quantile(values, 0.75);
  line.add(evolution::quantile(values, 0.5)).add(lower).add(upper).add(upper - lower);
  line.add(values.front()).add(values.back());
}

}  // namespace

RunStanding standing_of(const fs::path& run) {
  RunStanding standing;
  // Of one that was killed only whoever goes on with it can read the store, and tell its end.
  std::error_code error;
  if (!holds_run(run) || fs::exists(run / RunLock::file_name, error)) return standing;
  const Store store(run / store_name, Database::Access::read);
  if (says_complete(run)) standing.status = RunStatus::complete;
  standing.generations = store.generations();
  standing.set_aside = store.failures();
  const auto last = store.last();
  if (!last) return standing;
  const Store::Best best = store.best().value();
  standing.best = best.fitness;
  standing.best_generation = best.generation;
  standing.final_best = last->best;
  standing.final_median = last->median;
  return standing;
}

std::string index_csv(const Campaign& campaign, const std::vector<RunStanding>& standings) {
  CsvLine line;
  for (const char* name : {"run", "condition", "replicate", "seed", "status", "directory"})
    line.add(name);
  for (const std::string& factor : campaign.factors) line.add(factor);
  for (const char* name : {"generations", "best", "best_generation", "final_best", "final_median",
                           "set_aside", "reason"})
    line.add(name);
  std::string text = line.take();

  const std::vector<PlannedRun> runs = campaign.runs();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PlannedRun& run = runs[i];
    const Condition& condition = campaign.conditions[run.condition];
    const RunStanding& standing = standings[i];
    line.add(i + 1).add(condition.name).add(run.replicate).add(run.seed);
    line.add(name_of(standing.status)).add(run.directory.string());
    for (const std::string& level : condition.levels) line.add(level);
    if (standing.generations > 0) {
      line.add(standing.generations).add(standing.best).add(standing.best_generation);
      line.add(standing.final_best).add(standing.final_median).add(standing.set_aside);
    } else {
      for (int k = 0; k < 6; ++k) line.add("");
    }
    line.add(one_line(standing.reason));
    text += line.take();
  }
  return text;
}

std::string summary_csv(const Campaign& campaign, const std::vector<RunStanding>& standings) {
  CsvLine line;
  line.add("condition");
  for (const std::string& factor : campaign.factors) line.add(factor);
  for (const char* name : {"runs", "complete", "failed"}) line.add(name);
  for (const std::string measure : {"best", "final_best", "final_median"})
    for (const char* what : {"median", "lower_quartile", "upper_quartile", "iqr", "min", "max"})
      line.add(measure + "_" + what);
  std::string text = line.take();

  for (std::size_t c = 0; c < campaign.conditions.size(); ++c) {
    const Condition& condition = campaign.conditions[c];
    std::uint64_t failed = 0;
    std::vector<double> best, final_best, final_median;
    for (std::size_t r = 0; r < campaign.replicates; ++r) {
      const RunStanding& standing = standings[c * campaign.replicates + r];
      if (standing.status == RunStatus::failed) ++failed;
      if (standing.status != RunStatus::complete) continue;
      best.push_back(standing.best);
      final_best.push_back(standing.final_best);
      final_median.push_back(standing.final_median);
    }
    line.add(condition.name);
    for (const std::string& level : condition.levels) line.add(level);
    line.add(campaign.replicates).add(best.size()).add(failed);
    add_statistics(line, std::move(best));
    add_statistics(line, std::move(final_best));
    add_statistics(line, std::move(final_median));
    text += line.take();
  }
  return text;
}

}  // namespace somas::run
