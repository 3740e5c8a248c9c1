#include "core/evaluation/pool.hpp"

#include <algorithm>
#include <numeric>

#include "core/evaluation/dispatcher.hpp"

namespace somas::evaluation {
namespace {

class PoolEvaluator final : public Evaluator {
 public:
  PoolEvaluator(Pool::Dispatcher& dispatcher, const experiment::Experiment& experiment)
      : dispatcher_(dispatcher), experiment_(dispatcher.enter(experiment)) {}
  ~PoolEvaluator() override { dispatcher_.leave(experiment_); }
  PoolEvaluator(const PoolEvaluator&) = delete;
  PoolEvaluator& operator=(const PoolEvaluator&) = delete;

  [[nodiscard]] std::optional<std::vector<Result>> evaluate(
      std::span<const Task> tasks, StopToken stop, const ResultCallback& finished) override {
    return dispatcher_.evaluate(experiment_, tasks, stop, finished);
  }
  [[nodiscard]] std::optional<Reference> reference() override {
    return dispatcher_.reference(experiment_);
  }
  void expect(const Reference& reference) override { dispatcher_.expect(experiment_, reference); }

 private:
  Pool::Dispatcher& dispatcher_;
  std::uint32_t experiment_;
};

std::size_t places_of(const PoolOptions& options) {
  if (options.workers != 0) return options.workers;
  return std::max(1u, usable_processors() / options.world_threads);
}

StationMaker local_maker(const PoolOptions& options) {
  const LocalOptions local{.places = places_of(options),
                           .memory_mib = options.memory_mib,
                           .watchdog_seconds = options.watchdog_seconds,
                           .world_threads = options.world_threads,
                           .program = options.program};
  return [local] {
    std::vector<std::unique_ptr<Station>> stations;
    stations.push_back(local_station(local));
    return stations;
  };
}

std::string counted(std::size_t count, const std::string& noun, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? noun : plural);
}

}  // namespace

Pool::Pool(const PoolOptions& options)
    : dispatcher_(std::make_unique<Dispatcher>(std::vector<std::size_t>{places_of(options)},
                                               local_maker(options), options.warn)),
      description_(counted(places_of(options), "evaluator process", "evaluator processes")),
      world_threads_(options.world_threads) {}

Pool::Pool(std::vector<std::string> names, std::vector<std::size_t> places,
           StationMaker make_stations, std::function<void(const std::string&)> warn,
           unsigned world_threads)
    : description_(counted(std::accumulate(places.begin(), places.end(), std::size_t{0}),
                           "evaluator process", "evaluator processes") +
                   " of " + counted(names.size(), "rank", "ranks")),
      world_threads_(world_threads) {
  dispatcher_ =
      std::make_unique<Dispatcher>(std::move(places), std::move(make_stations), std::move(warn));
}

Pool::~Pool() = default;

std::unique_ptr<Evaluator> Pool::evaluator(const experiment::Experiment& experiment) {
  return std::make_unique<PoolEvaluator>(*dispatcher_, experiment);
}

unsigned Pool::workers() const { return static_cast<unsigned>(dispatcher_->workers()); }

double Pool::busy_seconds() const { return dispatcher_->busy_seconds(); }

std::string Pool::description() const { return description_; }

}  // namespace somas::evaluation
