#include "core/run/campaign_runner.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

#include "core/evaluation/crash_report.hpp"
#include "core/run/campaign_progress.hpp"
#include "core/run/campaign_tables.hpp"
#include "core/run/errors.hpp"
#include "core/run/files.hpp"
#include "core/run/progress.hpp"
#include "core/run/run_directory.hpp"
#include "core/run/run_lock.hpp"
#include "core/run/runner.hpp"

namespace somas::run {
namespace {

namespace fs = std::filesystem;

/// Enough runs that while some select, commit or wait for their last simulations, others keep all
/// evaluators busy; few enough that the first of them end soon.
std::uint64_t runs_at_once(const CampaignPlan& plan, const CampaignOptions& options) {
  if (options.at_once != 0) return options.at_once;
  std::uint64_t fewest = plan.conditions.front().evaluations;
  for (const CheckedCondition& condition : plan.conditions)
    fewest = std::min(fewest, condition.evaluations);
  const std::uint64_t workers = options.backend->workers();
  return std::max(std::clamp<std::uint64_t>(workers + 2, 3, 8),
                  2 + 2 * workers / std::max<std::uint64_t>(fewest, 1));
}

RunFault fault_of(const std::exception_ptr& error, std::string& reason) {
  try {
    std::rethrow_exception(error);
  } catch (const PluginError& what) {
    reason = what.what();
    return RunFault::plugin;
  } catch (const model::PluginFailure& what) {
    reason = what.what();
    return RunFault::plugin;
  } catch (const evaluation::ExperimentFails& what) {
    reason = what.what();
    return RunFault::plugin;
  } catch (const WriteError& what) {
    reason = what.what();
    return RunFault::disk;
  } catch (const evaluation::EvaluatorsLost& what) {
    reason = what.what();
    return RunFault::evaluators;
  } catch (const UsageError& what) {
    reason = what.what();
    return RunFault::input;
  } catch (const experiment::InputError& what) {
    reason = what.what();
    return RunFault::input;
  } catch (const std::bad_alloc&) {
    reason = "not enough memory";
  } catch (const std::exception& what) {
    reason = what.what();
  } catch (...) {
    reason = "internal error";
  }
  return RunFault::internal;
}

/// Whether the fault is nobody's own: then the others cannot go on either.
bool is_everybodys(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const WriteError&) {
    return true;
  } catch (const evaluation::PoolLost&) {
    return true;
  } catch (...) {
    return false;
  }
}

std::vector<fs::path> genomes_of(const fs::path& campaign) {
  std::vector<fs::path> files;
  for (std::size_t i = 0;; ++i) {
    fs::path file = campaign / "genomes" / ("given-" + std::to_string(i) + ".json");
    std::error_code error;
    if (!fs::exists(file, error)) return files;
    files.push_back(std::move(file));
  }
}

class CampaignRunner {
 public:
  /// `changes`: of a resume, what applies to each of its runs.
  CampaignRunner(const CampaignPlan& plan, fs::path directory, const CampaignOptions& options,
                 const CampaignResumeOptions& changes, Terminal& terminal,
                 evaluation::StopToken stop)
      : plan_(plan),
        campaign_(plan.campaign),
        directory_(std::move(directory)),
        options_(options),
        changes_(changes),
        terminal_(terminal),
        stop_(stop),
        genomes_(genomes_of(directory_)),
        runs_(campaign_.runs()),
        standings_(runs_.size()),
        faults_(runs_.size()) {
    look();
    line_up();
  }

  [[nodiscard]] CampaignReport carry_out() {
    announce();
    write_tables();
    const auto begun = std::chrono::steady_clock::now();
    const double busy_before = options_.backend->busy_seconds();
    const std::uint64_t at_once =
        std::min<std::uint64_t>(runs_at_once(plan_, options_), waiting_.size());
    {
      std::vector<std::jthread> threads;
      std::unique_lock lock(mutex_);
      for (left_ = at_once; threads.size() < at_once;) threads.emplace_back([this] { work(); });
      // Signals reach all runs through one flag; meanwhile the line of progress.
      while (left_ > 0) {
        news_.wait_for(lock, std::chrono::milliseconds(100), [&] { return left_ == 0; });
        if (stop_.stop_requested()) halt_ = true;
        if (!options_.quiet) progress_->update(done_, failed_, active_);
      }
    }
    progress_.reset();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begun;
    say_busy(options_.backend->busy_seconds() - busy_before, seconds.count());
    if (table_error_) std::rethrow_exception(table_error_);
    return report();
  }

 private:
  /// What there is already.
  void look() {
    std::vector<CampaignProgress::Work> work;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const CheckedCondition& condition = plan_.conditions[runs_[i].condition];
      RunStanding& standing = standings_[i];
      try {
        standing = standing_of(directory_ / runs_[i].directory);
      } catch (const UsageError&) {
        // Damaged: going on with it will tell.
      } catch (const WriteError&) {
      }
      // It would bring us down again, and the others with it.
      std::error_code ignored;
      const fs::path crash = crash_path(directory_ / runs_[i].directory);
      if (!changes_.accept_changes && fs::exists(crash, ignored)) {
        standing.status = RunStatus::failed;
        standing.reason = read_file(crash);
        while (standing.reason.ends_with('\n')) standing.reason.pop_back();
        faults_[i] = RunFault::plugin;
        ++failed_;
        ++done_;
      }
      // One that was complete may have been extended.
      if (standing.status == RunStatus::complete && standing.generations < condition.generations)
        standing.status = RunStatus::waiting;
      if (standing.status == RunStatus::complete) ++done_;
      const std::uint64_t finished = std::min(standing.generations, condition.generations);
      const bool goes_on = standing.status == RunStatus::waiting;
      work.push_back({.generations = goes_on ? condition.generations : finished,
                      .evaluations = condition.evaluations,
                      .finished = finished});
    }
    progress_.emplace(terminal_, work);
  }

  /// Those that have begun first, then replicate by replicate, so that all conditions show early.
  void line_up() {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < runs_.size(); ++i)
      if (standings_[i].status == RunStatus::waiting) order.push_back(i);
    const auto place = [&](std::size_t i) {
      return std::pair(!holds_run(directory_ / runs_[i].directory), runs_[i].replicate);
    };
    std::vector<std::pair<std::pair<bool, std::uint64_t>, std::size_t>> places;
    for (const std::size_t i : order) places.emplace_back(place(i), i);
    std::sort(places.begin(), places.end());
    for (const auto& [ignored, i] : places) waiting_.push_back(i);
  }

  void announce() const {
    if (options_.quiet) return;
    terminal_.line("campaign " + directory_.string() + ": " + size_text(campaign_) + ", " +
                   options_.backend->description() +
                   (done_ > 0 ? "; " + std::to_string(done_) + " done" : ""));
  }

  void say_busy(double busy, double seconds) const {
    const double whole = seconds * options_.backend->workers();
    if (options_.quiet || whole <= 0) return;
    terminal_.line("evaluators were at work " + std::to_string(std::lround(100 * busy / whole)) +
                   " % of " + duration_text(seconds));
  }

  /// What a thread of the campaign does: one run after the other.
  void work() {
    const evaluation::WatchedThread watched;  // a crash names the plugin
    while (const std::optional<std::size_t> run = next()) {
      RunStanding standing;
      std::exception_ptr error;
      try {
        const RunReport report = carry_out(runs_[*run], progress_->watcher(*run));
        standing.status = report.stopped ? RunStatus::stopped : RunStatus::complete;
      } catch (...) {
        error = std::current_exception();
      }
      ended(*run, standing.status, error);
    }
    const std::scoped_lock lock(mutex_);
    if (--left_ == 0) news_.notify_all();
  }

  std::optional<std::size_t> next() {
    const std::scoped_lock lock(mutex_);
    std::optional<std::size_t> run;
    if (!halt_ && !stop_.stop_requested() && !waiting_.empty()) {
      run = waiting_.front();
      waiting_.pop_front();
      standings_[*run].status = RunStatus::running;
      ++active_;
    }
    // What ended before is news as well.
    write_tables_or_halt();
    return run;
  }

  [[nodiscard]] RunReport carry_out(const PlannedRun& run, Watcher& watcher) {
    const fs::path path = directory_ / run.directory;
    const evaluation::StopToken stop(halt_);
    if (holds_run(path)) {
      ResumeOptions options;
      options.run = path;
      options.generations = campaign_.generations;
      options.accept_changes = changes_.accept_changes;
      options.plugin_path = changes_.plugin_path;
      options.backend = options_.backend;
      options.watcher = &watcher;
      return resume(options, terminal_, stop);
    }
    experiment::LoadOptions load = load_options(campaign_);
    load.overrides.push_back("seed=" + std::to_string(run.seed));
    experiment::Experiment experiment =
        experiment::load(condition_file(directory_, campaign_.conditions[run.condition]), load);
    experiment.original_yaml = campaign_.original_yaml;
    RunOptions options;
    options.file = campaign_.file;
    options.out = path;
    options.backend = options_.backend;
    options.watcher = &watcher;
    options.genomes = genomes_;
    options.plugin_path = campaign_.plugin_path;
    options.command_line = campaign_.command_of(run, genomes_.size());
    return somas::run::run(experiment, options, terminal_, stop);
  }

  void ended(std::size_t run, RunStatus status, const std::exception_ptr& error) {
    const std::string name = runs_[run].directory.string();
    RunStanding standing;
    try {
      standing = standing_of(directory_ / runs_[run].directory);
    } catch (const std::exception&) {
      // What is wrong with it is the reason for its end.
    }
    standing.status = status;

    const std::scoped_lock lock(mutex_);
    --active_;
    if (error) {
      standing.status = RunStatus::failed;
      faults_[run] = fault_of(error, standing.reason);
      if (is_everybodys(error)) halt_ = true;
      ++failed_;
      progress_->give_up(run);
      terminal_.line("warning: run " + name + " failed: " + standing.reason);
    }
    if (standing.status != RunStatus::stopped) ++done_;
    standings_[run] = std::move(standing);
    if (!options_.quiet && !error && !halt_) progress_->ended(name, done_, failed_, active_);
  }

  void write_tables() {
    write_file(directory_ / "index.csv", index_csv(campaign_, standings_));
    write_file(directory_ / "summary.csv", summary_csv(campaign_, standings_));
  }

  /// A disk that is full stops all runs, each of which saves what it can.
  void write_tables_or_halt() {
    try {
      write_tables();
    } catch (const WriteError&) {
      if (!table_error_) table_error_ = std::current_exception();
      halt_ = true;
    }
  }

  [[nodiscard]] CampaignReport report() const {
    CampaignReport report{.directory = directory_,
                          .runs = runs_.size(),
                          .conditions = campaign_.conditions.size(),
                          .complete = 0,
                          .failed = failed_,
                          .fault = RunFault::none,
                          .stopped = done_ < runs_.size(),
                          .best = {},
                          .best_run = {}};
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (report.fault == RunFault::none) report.fault = faults_[i];
      const RunStanding& standing = standings_[i];
      if (standing.status == RunStatus::complete) ++report.complete;
      if (standing.generations == 0 || (report.best && *report.best >= standing.best)) continue;
      report.best = standing.best;
      report.best_run = runs_[i].directory.string();
    }
    return report;
  }

  const CampaignPlan& plan_;
  const Campaign& campaign_;
  fs::path directory_;
  const CampaignOptions& options_;
  const CampaignResumeOptions& changes_;
  Terminal& terminal_;
  evaluation::StopToken stop_;
  std::vector<fs::path> genomes_;
  std::vector<PlannedRun> runs_;

  std::atomic<bool> halt_ = false;  ///< seen by all runs
  std::mutex mutex_;                ///< guards what follows
  std::condition_variable news_;
  std::vector<RunStanding> standings_;
  std::vector<RunFault> faults_;
  std::deque<std::size_t> waiting_;
  std::uint64_t done_ = 0, failed_ = 0, active_ = 0, left_ = 0;
  std::exception_ptr table_error_;
  std::optional<CampaignProgress> progress_;
};

/// The command line that goes on with the campaign after a crash; empty: none.
std::vector<std::string> restart_words(const fs::path& directory, const CampaignOptions& options) {
  if (!options.restart) return {};
  std::vector<std::string> words = {"resume", directory.string()};
  words.insert(words.end(), options.restart->begin(), options.restart->end());
  return words;
}

/// All that a resume needs; campaign.json comes last: with it the campaign has begun.
void write_campaign(const fs::path& directory, const CampaignPlan& plan) {
  make_directory_in(directory / "conditions");
  for (std::size_t i = 0; i < plan.conditions.size(); ++i) {
    const Condition& condition = plan.campaign.conditions[i];
    write_file(condition_file(directory, condition), plan.conditions[i].resolved_yaml);
  }
  write_file(directory / "campaign.json", to_text(campaign_to_json(plan.campaign)));
}

}  // namespace

CampaignReport run_campaign(const CampaignPlan& given, const std::optional<fs::path>& out,
                            const std::vector<fs::path>& genomes, const CampaignOptions& options,
                            Terminal& terminal, evaluation::StopToken stop) {
  std::vector<std::string> texts;
  for (const fs::path& genome : genomes) texts.push_back(read_file(genome));
  const fs::path directory = make_campaign_directory(out, given.campaign.experiment);
  const RunLock lock(directory);
  clear_beginning(directory);
  CampaignPlan plan = given;
  plan.campaign.directory = directory;
  create_file(directory / "experiment.yaml", plan.campaign.original_yaml);
  if (!texts.empty()) make_directory_in(directory / "genomes");
  for (std::size_t i = 0; i < texts.size(); ++i)
    create_file(directory / "genomes" / ("given-" + std::to_string(i) + ".json"), texts[i]);
  write_campaign(directory, plan);
  const evaluation::RestartAfterCrash restart(restart_words(directory, options));
  return CampaignRunner(plan, directory, options, {}, terminal, stop).carry_out();
}

namespace {

/// The campaign with more replicates, or longer runs.
Campaign extended(Campaign campaign, const CampaignResumeOptions& resume) {
  const auto refuse = [](const std::string& option, std::uint64_t value, const std::string& why) {
    throw UsageError("--" + option + " " + std::to_string(value) + ": " + why);
  };
  if (resume.replicates && *resume.replicates < campaign.replicates)
    refuse("replicates", *resume.replicates,
           "the campaign has " + std::to_string(campaign.replicates) + " already");
  if (resume.replicates && campaign.conditions.size() * *resume.replicates > experiment::most_runs)
    refuse("replicates", *resume.replicates,
           "more than " + std::to_string(experiment::most_runs) + " runs");
  if (resume.replicates) campaign.replicates = *resume.replicates;
  if (!resume.generations) return campaign;
  const auto& factors = campaign.factors;
  if (std::find(factors.begin(), factors.end(), "evolution.generations") != factors.end())
    refuse("generations", *resume.generations, "evolution.generations is a factor of the sweep");
  for (const PlannedRun& run : campaign.runs()) {
    const std::uint64_t finished = standing_of(resume.directory / run.directory).generations;
    if (*resume.generations < finished)
      refuse("generations", *resume.generations,
             (resume.directory / run.directory).string() + " has finished " +
                 std::to_string(finished) + " already");
  }
  campaign.generations = resume.generations;
  return campaign;
}

}  // namespace

CampaignReport resume_campaign(const CampaignResumeOptions& resume, const CampaignOptions& options,
                               Terminal& terminal, evaluation::StopToken stop) {
  const RunLock lock(resume.directory);
  for (const char* place : {"", "conditions"}) remove_temporary_files(resume.directory / place);
  Campaign campaign = extended(read_campaign(resume.directory), resume);
  if (!resume.plugin_path.empty()) campaign.plugin_path = resume.plugin_path;
  if (!resume.sweeps.empty())
    write_campaign(resume.directory, with_more_levels(resume.directory, campaign, resume.sweeps));
  else if (resume.replicates || resume.generations)
    write_file(resume.directory / "campaign.json", to_text(campaign_to_json(campaign)));
  if (!resume.sweeps.empty()) campaign = read_campaign(resume.directory);
  const CampaignPlan plan = reload_campaign(resume.directory, std::move(campaign));
  const evaluation::RestartAfterCrash restart(restart_words(resume.directory, options));
  return CampaignRunner(plan, resume.directory, options, resume, terminal, stop).carry_out();
}

}  // namespace somas::run
