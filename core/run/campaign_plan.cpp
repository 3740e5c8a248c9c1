#include "core/run/campaign_plan.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>
#include <utility>

#include "core/evolution/matching.hpp"
#include "core/evolution/reproduction.hpp"
#include "core/plugins/suggest.hpp"
#include "core/run/contest.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/progress.hpp"
#include "core/run/runner.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;
using plugins::plural;

constexpr std::size_t most_samples = 4;
constexpr std::chrono::milliseconds longest_sample{1000};

/// What is wrong with conditions, each thing once, with the conditions that it is wrong with.
class Faults {
 public:
  void add(const std::string& message, const std::string& condition) {
    std::istringstream lines(message);
    std::string fault;
    for (std::string line; std::getline(lines, line);) {
      // What is indented belongs to the line above.
      if (!fault.empty() && !line.starts_with(' ')) add_one(std::exchange(fault, ""), condition);
      fault += (fault.empty() ? "" : "\n") + line;
    }
    add_one(fault, condition);
  }
  /// `all`: how many conditions there are; what is wrong with each needs no name.
  void raise(std::size_t all) const {
    std::string text;
    for (const std::string& line : order_) {
      const std::vector<std::string>& where = conditions_.at(line);
      text += (text.empty() ? "" : "\n") + line;
      if (where.size() == all) continue;
      text += " (condition " + where.front();
      if (where.size() > 1) text += " and " + std::to_string(where.size() - 1) + " more";
      text += ")";
    }
    if (!text.empty()) throw UsageError(text);
  }

 private:
  void add_one(const std::string& fault, const std::string& condition) {
    std::vector<std::string>& conditions = conditions_[fault];
    if (conditions.empty()) order_.push_back(fault);
    if (conditions.empty() || conditions.back() != condition) conditions.push_back(condition);
  }

  std::vector<std::string> order_;
  std::map<std::string, std::vector<std::string>> conditions_;
};

CheckedCondition checked(const experiment::Experiment& experiment) {
  return {.resolved_yaml = experiment.resolved_yaml,
          .generations = experiment.evolution.generations,
          .evaluations = evolution::matches(experiment.evolution, experiment.seed, 0).size()};
}

void refuse_equal_conditions(const CampaignPlan& plan) {
  std::map<std::string, std::string> names;
  for (std::size_t i = 0; i < plan.conditions.size(); ++i) {
    const std::string& name = plan.campaign.conditions[i].name;
    const auto [first, is_new] = names.try_emplace(plan.conditions[i].resolved_yaml, name);
    if (!is_new)
      throw UsageError(plan.campaign.file.string() + ": sweep: the conditions " + first->second +
                       " and " + name + " are the same experiment, every key has the same value");
  }
}

/// Loads all with `load`, which gets the index of a condition.
template <class Load>
void check_all(CampaignPlan& plan, const std::vector<fs::path>& genomes, const Load& load) {
  const std::size_t count = plan.campaign.conditions.size();
  const std::size_t distance = std::max<std::size_t>(1, count / most_samples);
  Faults faults;
  for (std::size_t i = 0; i < count; ++i) {
    try {
      experiment::Experiment experiment = load(i);
      check_genomes(genomes, experiment);
      plan.conditions.push_back(checked(experiment));
      if (i % distance == 0 && plan.samples.size() < most_samples)
        plan.samples.push_back(std::move(experiment));
    } catch (const experiment::InputError& error) {
      faults.add(error.what(), plan.campaign.conditions[i].name);
    } catch (const UsageError& error) {
      faults.add(error.what(), plan.campaign.conditions[i].name);
    }
  }
  faults.raise(count);
  refuse_equal_conditions(plan);
}

bool sets(const std::string& assignment, std::string_view key) {
  return assignment.starts_with(key) && assignment.substr(key.size()).starts_with('=');
}

/// Sets the flag after a while, unless it ends before.
class Alarm {
 public:
  Alarm(std::atomic<bool>& flag, std::chrono::milliseconds after, evaluation::StopToken stop)
      : thread_([&flag, after, stop](const std::stop_token& ended) {
          std::mutex mutex;
          std::condition_variable_any news;
          std::unique_lock lock(mutex);
          const auto end = std::chrono::steady_clock::now() + after;
          while (!ended.stop_requested() && !stop.stop_requested() &&
                 std::chrono::steady_clock::now() < end)
            news.wait_for(lock, ended, std::chrono::milliseconds(50), [] { return false; });
          flag = true;
        }) {}

 private:
  std::jthread thread_;
};

struct Sample {
  double per_second = 0;
  double genome_bytes = 0;  ///< mean
};

Sample sample(const experiment::Experiment& experiment, evaluation::Backend& backend,
              evaluation::StopToken stop) {
  const evolution::Settings& settings = experiment.evolution;
  const evolution::Heredity heredity(*experiment.ecosystem);
  std::vector<evolution::Population> populations(evolution::population_count(settings));
  double bytes = 0, count = 0;
  for (std::uint32_t p = 0; p < populations.size(); ++p) {
    populations[p] =
        evolution::initial(settings, heredity, evolution::population_seed(experiment.seed, p), {});
    for (const evolution::Individual& individual : populations[p]) {
      bytes += static_cast<double>(individual.genome.length());
      ++count;
    }
  }
  const Contest contest(settings, heredity, experiment.seed, 0, populations, {});
  std::vector<evaluation::Task> tasks = contest.tasks();
  tasks.resize(std::min<std::size_t>(tasks.size(), std::size_t{16} * backend.workers()));

  // The clock starts with the first result: before that, processes start and load.
  std::atomic<bool> over = false;
  std::size_t results = 0;
  std::chrono::steady_clock::time_point first, last;
  {
    const Alarm alarm(over, longest_sample, stop);
    const auto evaluator = backend.evaluator(experiment);
    static_cast<void>(evaluator->evaluate(tasks, evaluation::StopToken(over),
                                          [&](std::size_t, const evaluation::Result&) {
                                            last = std::chrono::steady_clock::now();
                                            if (results++ == 0) first = last;
                                          }));
  }
  const std::chrono::duration<double> seconds = last - first;
  Sample sample{.per_second = 0, .genome_bytes = bytes / std::max(count, 1.0)};
  if (results > 1 && seconds.count() > 0)
    sample.per_second = static_cast<double>(results - 1) / seconds.count();
  return sample;
}

std::string bytes_text(double bytes) {
  constexpr const char* units[] = {"kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (bytes /= 1000; bytes >= 1000 && unit + 1 < std::size(units); bytes /= 1000) ++unit;
  char text[32];
  std::snprintf(text, sizeof text, bytes < 10 ? "%.1f %s" : "%.0f %s", bytes, units[unit]);
  return text;
}

std::string joined_levels(const CampaignPlan& plan, std::size_t factor) {
  std::vector<std::string> levels;
  for (const Condition& condition : plan.campaign.conditions)
    if (std::find(levels.begin(), levels.end(), condition.levels[factor]) == levels.end())
      levels.push_back(condition.levels[factor]);
  return plugins::join(levels);
}

}  // namespace

std::uint64_t CampaignPlan::evaluations() const {
  std::uint64_t sum = 0;
  for (const CheckedCondition& condition : conditions)
    sum += campaign.replicates * condition.generations * condition.evaluations;
  return sum;
}

CampaignPlan plan_campaign(const experiment::Design& design, const CampaignRequest& request) {
  CampaignPlan plan;
  Campaign& campaign = plan.campaign;
  campaign.experiment = design.name;
  campaign.file = request.file;
  campaign.original_yaml = design.original_yaml;
  campaign.seed = design.seed;
  campaign.replicates = design.replicates;
  for (const experiment::Factor& factor : design.factors) campaign.factors.push_back(factor.name);
  campaign.conditions = conditions_of(design);
  // The seed is each run's own.
  for (const std::string& assignment : request.overrides)
    if (!sets(assignment, "seed") && !sets(assignment, "replicates"))
      campaign.overrides.push_back(assignment);
  campaign.sweeps = request.sweeps;
  for (const fs::path& path : request.plugin_path)
    campaign.plugin_path.push_back(fs::absolute(path).lexically_normal());
  campaign.command_line = request.command_line;

  check_all(plan, request.genomes, [&](std::size_t i) {
    return experiment::load(request.file, {.overrides = request.overrides,
                                           .plugin_directories = request.plugin_path,
                                           .levels = campaign.conditions[i].sets});
  });
  return plan;
}

CampaignPlan with_more_levels(const fs::path& directory, const Campaign& campaign,
                              const std::vector<std::string>& sweeps) {
  const auto key_of = [](const std::string& text) { return text.substr(0, text.find('=')); };
  CampaignRequest request{.file = campaign.file,
                          .overrides = campaign.overrides,
                          .sweeps = campaign.sweeps,
                          .plugin_path = campaign.plugin_path,
                          .command_line = campaign.command_line};
  request.overrides.push_back("seed=" + std::to_string(campaign.seed));
  request.overrides.push_back("replicates=" + std::to_string(campaign.replicates));
  for (const std::string& sweep : sweeps) {
    std::erase_if(request.sweeps,
                  [&](const std::string& other) { return key_of(other) == key_of(sweep); });
    request.sweeps.push_back(sweep);
  }
  const auto design =
      experiment::read_design(request.file, {request.overrides, request.sweeps, true});
  CampaignPlan plan = plan_campaign(*design, request);
  if (plan.campaign.factors != campaign.factors)
    throw UsageError("--sweep: " + directory.string() + " has the factors " +
                     plugins::join(campaign.factors) +
                     ", which get more levels; with others it is another campaign");
  for (const Condition& condition : campaign.conditions) {
    const auto& all = plan.campaign.conditions;
    const auto same = std::find_if(all.begin(), all.end(), [&](const Condition& other) {
      return other.name == condition.name;
    });
    if (same == all.end())
      throw UsageError("--sweep: the condition " + condition.name + " of " + directory.string() +
                       " would go; name the levels that are there, too");
    const auto index = static_cast<std::size_t>(same - all.begin());
    if (plan.conditions[index].resolved_yaml != read_file(condition_file(directory, condition)))
      throw UsageError(campaign.file.string() + " has changed since " + directory.string() +
                       " began: the condition " + condition.name +
                       " would not be what it was; begin another campaign");
  }
  plan.campaign.original_yaml = campaign.original_yaml;
  plan.campaign.directory = campaign.directory;
  plan.campaign.generations = campaign.generations;
  return plan;
}

experiment::LoadOptions load_options(const Campaign& campaign) {
  experiment::LoadOptions options;
  options.plugin_directories = campaign.plugin_path;
  if (campaign.generations)
    options.overrides.push_back("evolution.generations=" + std::to_string(*campaign.generations));
  return options;
}

CampaignPlan reload_campaign(const fs::path& directory, Campaign campaign) {
  CampaignPlan plan;
  plan.campaign = std::move(campaign);
  check_all(plan, {}, [&](std::size_t i) {
    return experiment::load(condition_file(directory, plan.campaign.conditions[i]),
                            load_options(plan.campaign));
  });
  return plan;
}

CampaignCost cost_of(const CampaignPlan& plan, evaluation::Backend& backend,
                     evaluation::StopToken stop) {
  CampaignCost cost{.evaluations = plan.evaluations()};
  double seconds = 0, genome_bytes = 0, known = 0, samples = 0;
  for (const experiment::Experiment& experiment : plan.samples) {
    try {
      const Sample one = sample(experiment, backend, stop);
      genome_bytes += one.genome_bytes;
      ++samples;
      if (one.per_second <= 0) continue;
      seconds += 1 / one.per_second;
      ++known;
    } catch (const evaluation::EvaluatorsLost&) {
      // What a plugin does to a sample it does to its run as well, which will say so.
    } catch (const evaluation::ExperimentFails&) {
    } catch (const model::PluginFailure&) {
    }
  }
  if (known > 0) cost.per_second = known / seconds;
  // Rows of the store and lines of the CSV files, and the champion's file, as runs were measured.
  constexpr double of_individual = 620, of_generation = 60e3, of_run = 160e3;
  for (const CheckedCondition& condition : plan.conditions) {
    const auto generations = static_cast<double>(condition.generations);
    const double individuals = static_cast<double>(condition.evaluations);
    cost.bytes +=
        static_cast<double>(plan.campaign.replicates) *
        (of_run +
         generations * (of_generation +
                        individuals * (of_individual + genome_bytes / std::max(samples, 1.0))));
  }
  return cost;
}

std::string size_text(const Campaign& campaign) {
  const std::uint64_t runs = campaign.replicates * campaign.conditions.size();
  std::string text = plural(campaign.conditions.size(), "condition") + " x " +
                     plural(campaign.replicates, "replicate") + " = " + plural(runs, "run");
  text += campaign.replicates == 1 ? ", seed " + std::to_string(campaign.seed)
                                   : ", seeds " + std::to_string(campaign.seed) + " to " +
                                         std::to_string(campaign.seed + campaign.replicates - 1);
  return text;
}

std::string plan_text(const CampaignPlan& plan, std::size_t most) {
  const Campaign& campaign = plan.campaign;
  std::string text = campaign.experiment + ": " + size_text(campaign) + "\n";
  for (std::size_t f = 0; f < campaign.factors.size(); ++f)
    text += "  factor " + campaign.factors[f] + ": " + joined_levels(plan, f) + "\n";
  for (std::size_t i = 0; i < campaign.conditions.size() && i < most; ++i)
    text += "  " + campaign.conditions[i].name + ": " +
            plural(plan.conditions[i].generations, "generation") + " of " +
            plural(plan.conditions[i].evaluations, "evaluation") + "\n";
  if (campaign.conditions.size() > most)
    text += "  and " + plural(campaign.conditions.size() - most, "condition") + " more\n";
  return text + "  in all: " + plural(plan.evaluations(), "evaluation") + "\n";
}

std::string cost_text(const CampaignCost& cost) {
  std::string text = "cost: " + plural(cost.evaluations, "evaluation");
  if (cost.per_second > 0) {
    const double seconds = static_cast<double>(cost.evaluations) / cost.per_second;
    text += ", " + duration_text(seconds) + " at the pace of random organisms (" +
            std::to_string(std::lround(std::max(1.0, cost.per_second))) +
            " a second), and longer as evolved ones live longer";
  } else {
    text += ", none of which ended within a second";
  }
  return text + "; about " + bytes_text(cost.bytes) + " on the disk, recordings apart";
}

}  // namespace somas::run
