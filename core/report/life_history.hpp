// A life as numbers, step by step: cells by state, deaths by cause, what the environment offered.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/model/simulation.hpp"
#include "core/recording/sink.hpp"

namespace somas::report {

/// Sees a simulation, or hears a recording as its sink: of the organism that it is about.
class LifeHistory final : public recording::Sink {
 public:
  /// `organism`: place in the roster of the one whose life it is.
  explicit LifeHistory(std::size_t organism = 0) : organism_(organism) {}

  /// Call after every step.
  void observe(const model::Simulation& simulation);

  void begin(const recording::Header& header) override;
  void event(const recording::Event& event) override;
  void summary(const recording::Summary& summary) override;
  /// Between frames tables keep their rows.
  void frame(const recording::Frame& frame) override;
  void finish(const recording::Ending&) override {}

  /// All by state, cause, resource or table, then by step; the first entry is that of first_step.
  struct Series {
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;
  };
  [[nodiscard]] std::size_t organism() const { return organism_; }  ///< place in the roster
  [[nodiscard]] std::size_t steps() const { return steps_.size(); }
  [[nodiscard]] const std::vector<double>& step() const { return steps_; }
  [[nodiscard]] const Series& cells() const { return cells_; }    ///< live, by state
  [[nodiscard]] const Series& deaths() const { return deaths_; }  ///< in the step, by cause
  /// Content of their grids: squares whose centre is in the world.
  [[nodiscard]] const Series& resources() const { return resources_; }
  [[nodiscard]] const Series& tables() const { return tables_; }  ///< rows
  [[nodiscard]] const std::vector<double>& divisions() const {
    return divisions_;
  }  ///< in the step
  [[nodiscard]] const std::vector<double>& specializations() const { return specializations_; }
  /// Live cells of all states.
  [[nodiscard]] std::vector<double> total() const;
  /// Content of all resources, relative to the most there ever was; all 1 without resources.
  [[nodiscard]] std::vector<double> availability() const;

 private:
  void describe(const recording::Header& header);
  [[nodiscard]] const model::OrganismState& own(const model::Simulation& simulation) const;
  [[nodiscard]] double content(std::size_t resource, const std::vector<double>& squares) const;

  std::size_t organism_;
  std::vector<double> steps_;
  Series cells_, deaths_, resources_, tables_;
  std::vector<double> divisions_, specializations_;
  std::vector<std::uint64_t> deaths_before_;
  std::uint64_t divisions_before_ = 0, specializations_before_ = 0;
  std::vector<std::size_t> grids_;                    ///< of the resources
  std::vector<std::vector<std::uint32_t>> in_world_;  ///< squares, by resource
  std::uint16_t own_ = 0;                             ///< in a recording
  std::uint32_t first_slot_ = 0;
  std::vector<double> deaths_heard_, rows_heard_;  ///< of a recording's step, of its last frame
  double births_heard_ = 0, specializations_heard_ = 0;
};

/// A phase of a life, as long as its boundaries can be found:
///   proliferation   from the first step;
///   specialization  from the first step at which a twentieth of the live cells is in another state
///                   than the founder's, if that comes before the decline;
///   decline         after the last step with at least 90 % of the most cells there ever were;
///   remnant         from where on there are never again more than 25 % of them.
/// One that is shorter than a hundredth of the life belongs to the one before it.
struct Phase {
  std::string name;
  double first = 0, last = 0;  ///< steps
};
[[nodiscard]] std::vector<Phase> phases_of(const LifeHistory& history);

}  // namespace somas::report
