#include "core/recording/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/core/recording/life.hpp"

namespace somas::recording {
namespace {

using model::Simulation;
using model::test::Bench;

class Recorded : public testing::Test {
 protected:
  Recorded() {
    test::set_up(bench_);
    recording_ = test::record(bench_);
  }
  [[nodiscard]] std::uint64_t count(EventKind kind, std::uint16_t organism) const {
    std::uint64_t found = 0;
    for (const Event& event : recording_.events)
      found += event.kind == kind && event.organism == organism ? 1 : 0;
    return found;
  }

  Bench bench_;
  Recording recording_;
};

TEST_F(Recorded, NeverChangesTheLife) {
  Bench unwatched;
  test::set_up(unwatched);
  const std::vector<std::uint64_t> alone = test::live(unwatched.start(), nullptr);
  Bench watched;
  test::set_up(watched);
  Simulation& simulation = watched.start();
  Collector collector;
  Recorder recorder(watched.ecosystem(), 0, collector);
  EXPECT_EQ(test::live(simulation, &recorder), alone);
  EXPECT_EQ(collector.recording().frames.size(), alone.size());
}

TEST_F(Recorded, TellsWhoIsThere) {
  const Header& header = recording_.header;
  EXPECT_EQ(header.provenance.experiment, "busy");
  EXPECT_EQ(header.seed, 3u);
  EXPECT_EQ(header.first_step, 0u);
  ASSERT_EQ(header.organisms.size(), 2u);
  EXPECT_EQ(header.organisms[0].key, 4u);  // by ascending key, whatever the roster
  EXPECT_EQ(header.organisms[0].seat, 1u);
  EXPECT_EQ(header.own, 1u);
  EXPECT_EQ(header.organisms[1].first_slot, 2u);
  EXPECT_EQ(header.slots(), 4u);
  EXPECT_EQ(header.organisms[0].states[1].name, "leaf");
  EXPECT_EQ(header.organisms[0].states[0].parent, none);
  EXPECT_EQ(header.organisms[0].states[1].parent, 0u);
  EXPECT_EQ(header.organisms[0].states[0].capacity, 10);
  EXPECT_EQ(header.inputs, (std::vector<std::string>{"morphogen.0", "morphogen.1", "morphogen.2",
                                                     "pressure", "energy", "ambrosia", "content"}));
  EXPECT_EQ(header.organisms[0].outputs.back(), "uptake.food");
  EXPECT_EQ(header.causes,
            (std::vector<std::string>{"starvation", "apoptosis", "outside", "fire", "bolt"}));
  EXPECT_EQ(header.hazards, std::vector<std::string>{"fire"});
  EXPECT_EQ(header.values, std::vector<std::string>{"fiery.wounds"});
  ASSERT_EQ(header.grids.size(), 1u);
  EXPECT_EQ(header.grids[0].name, "growing.content");
  EXPECT_EQ(header.grids[0].resource, "food");
  ASSERT_EQ(header.tables.size(), 1u);
  EXPECT_EQ(header.tables[0].columns, (std::vector<std::string>{"cell", "energy"}));
}

TEST_F(Recorded, EventsEqualWhatTheOutcomesCount) {
  std::uint64_t refused = 0, specialized = 0;
  for (std::uint16_t k = 0; k < 2; ++k) {
    const Outcome& outcome = recording_.ending.outcomes[k];
    EXPECT_GT(outcome.divisions, 10u);
    EXPECT_EQ(count(EventKind::birth, k), outcome.divisions);
    EXPECT_EQ(count(EventKind::specialization, k), outcome.specializations);
    EXPECT_EQ(count(EventKind::refused_division, k), outcome.refused_divisions);
    EXPECT_EQ(1 + outcome.divisions - count(EventKind::death, k), outcome.final_cells);
    refused += outcome.refused_divisions;
    specialized += outcome.specializations;
  }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(specialized, 0u);
}

TEST_F(Recorded, DeathsEqualTheWorldsByCause) {
  const model::WorldState& world = bench_.simulation().state();
  std::set<std::uint16_t> seen;
  for (std::uint16_t k = 0; k < 2; ++k) {
    std::vector<std::uint64_t> deaths(recording_.header.causes.size(), 0);
    for (const Event& event : recording_.events) {
      if (event.kind != EventKind::death || event.organism != k) continue;
      ++deaths.at(event.cause);
      seen.insert(event.cause);
    }
    EXPECT_EQ(deaths, world.organisms[k].deaths);
  }
  EXPECT_GE(seen.size(), 4u);  // the life was busy enough to show it
}

TEST_F(Recorded, CellsOfAFrameAreThoseThatEventsLeave) {
  std::set<std::pair<std::uint16_t, std::uint32_t>> living{{0, 0}, {1, 0}};
  std::map<std::pair<std::uint16_t, std::uint32_t>, std::uint16_t> states;
  std::size_t next = 0;
  for (const Frame& frame : recording_.frames) {
    for (; next < recording_.events.size() && recording_.events[next].step <= frame.step; ++next) {
      const Event& event = recording_.events[next];
      if (event.kind == EventKind::birth) living.insert({event.organism, event.cell});
      if (event.kind == EventKind::death) living.erase({event.organism, event.cell});
      if (event.kind == EventKind::birth || event.kind == EventKind::specialization)
        states[{event.organism, event.cell}] = event.state;
    }
    std::set<std::pair<std::uint16_t, std::uint32_t>> present;
    for (std::size_t c = 0; c < frame.cells.size(); ++c) {
      const std::pair who(frame.cells.organism[c], frame.cells.id[c]);
      if (!present.empty()) {
        EXPECT_LT(*present.rbegin(), who);  // ascending
      }
      present.insert(who);
      EXPECT_EQ(frame.cells.state[c], states[who]);
    }
    EXPECT_EQ(present, living) << "step " << frame.step;
  }
}

// What state a gives away arrives less what its efficiency loses; what the dying give is booked
// with it. So the books close over the flux of each organism.
TEST_F(Recorded, FluxEqualsTheBooks) {
  const std::map<std::uint16_t, double> efficiency{{0, 0.5}, {1, 0.8}};
  for (std::uint16_t k = 0; k < 2; ++k) {
    double lost = 0, given = 0, received = 0, inside = 0;
    for (const Summary& summary : recording_.summaries)
      for (const Flux& flux : summary.flux) {
        if (flux.from_organism == k)
          lost +=
              flux.amount / efficiency.at(flux.from_state) * (1 - efficiency.at(flux.from_state));
        if (flux.from_organism == k && flux.to_organism != k) given += flux.amount;
        if (flux.from_organism != k && flux.to_organism == k) received += flux.amount;
        if (flux.from_organism == k && flux.to_organism == k) inside += flux.amount;
      }
    const model::Ledger& ledger = bench_.simulation().state().organisms[k].ledger;
    EXPECT_GT(inside, 0.1);
    EXPECT_GT(given, 0);
    EXPECT_NEAR(lost, ledger.lost_efficiency.value(), 1e-9);
    EXPECT_NEAR(given, ledger.given.value(), 1e-9);
    EXPECT_NEAR(received, ledger.received.value(), 1e-9);
  }
}

TEST_F(Recorded, TheLastFrameIsTheWorldAtTheEnd) {
  const model::WorldState& world = bench_.simulation().state();
  const Frame& frame = recording_.frames.back();
  ASSERT_EQ(frame.step, world.step - 1);
  ASSERT_EQ(frame.cells.size(), world.cells.size());
  ASSERT_GT(frame.cells.size(), 5u);
  for (std::size_t c = 0; c < frame.cells.size(); ++c) {
    const std::uint32_t i = world.cells.order[c];
    EXPECT_EQ(frame.cells.id[c], world.cells.id[i]);
    EXPECT_EQ(frame.cells.parent[c], world.cells.parent[i]);
    EXPECT_EQ(frame.cells.born[c], world.cells.born[i]);
    EXPECT_EQ(frame.cells.x[c], static_cast<float>(world.cells.x[i]));
    EXPECT_EQ(frame.cells.y[c], static_cast<float>(world.cells.y[i]));
    EXPECT_EQ(frame.cells.radius[c], static_cast<float>(world.cells.radius[i]));
    EXPECT_EQ(frame.cells.energy[c], static_cast<float>(world.cells.energy[i]));
    EXPECT_EQ(frame.cells.ambrosia[c], static_cast<float>(world.cells.ambrosia[i]));
    EXPECT_EQ(frame.cells.pressure[c], static_cast<float>(world.cells.pressure[i]));
    EXPECT_EQ(frame.cells.action[c], static_cast<std::uint8_t>(world.cells.action[i]));
    EXPECT_EQ(frame.cells.damage[0][c], static_cast<float>(world.cells.damage[0][i]));
    EXPECT_EQ(frame.cells.values[0][c], static_cast<float>(world.cells.values[0][i]));
  }
  for (std::size_t square = 0; square < world.grids[0].size(); ++square)
    ASSERT_EQ(frame.grids[0][square], static_cast<float>(world.grids[0][square]));
  ASSERT_EQ(frame.morphogens.size(), 2u);
  const model::MorphogenFields& fields = world.organisms[0].fields;
  double sum = 0;
  for (std::uint32_t row = 0; row < fields.size(); ++row)
    for (std::uint32_t column = 0; column < fields.size(); ++column) {
      ASSERT_EQ(frame.morphogens[0][1][row * fields.size() + column], fields.value(1, column, row));
      sum += fields.value(1, column, row);
    }
  EXPECT_GT(sum, 0);
}

TEST_F(Recorded, SummariesAreThoseOfTheFrames) {
  ASSERT_EQ(recording_.summaries.size(), recording_.frames.size());
  for (std::size_t s = 0; s < recording_.summaries.size(); ++s) {
    const Summary& summary = recording_.summaries[s];
    const Frame& frame = recording_.frames[s];
    EXPECT_EQ(summary.step, s);
    std::vector<std::uint32_t> population(4, 0);
    double energy = 0;
    std::size_t cells = 0;
    for (std::size_t c = 0; c < frame.cells.size(); ++c) {
      ++population[2u * frame.cells.organism[c] + frame.cells.state[c]];
      if (frame.cells.organism[c] != 1) continue;
      energy += static_cast<double>(frame.cells.energy[c]);
      ++cells;
    }
    EXPECT_EQ(summary.population, population);
    EXPECT_NEAR(summary.energy[1], cells == 0 ? 0 : energy / static_cast<double>(cells), 1e-6);
    double content = 0;
    for (std::size_t square = 0; square < frame.grids[0].size(); ++square) {
      const double x = -64 + 2 * (static_cast<double>(square % 64) + 0.5);
      const double y = -64 + 2 * (static_cast<double>(square / 64) + 0.5);
      if (std::hypot(x, y) <= 7.5) content += static_cast<double>(frame.grids[0][square]);
    }
    EXPECT_NEAR(summary.grid_totals[0], content, 1e-4);
  }
}

// The script draws each output from id and step, so what must stand there can be computed.
TEST_F(Recorded, ControllerOutputsBelongToTheirCells) {
  const auto at = [&](const char* name) {
    const auto& names = recording_.header.organisms[0].outputs;
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::size_t newborn = 0, old = 0;
  for (const Frame& frame : recording_.frames)
    for (std::size_t c = 0; c < frame.cells.size(); ++c) {
      const float conversion = frame.cells.outputs[at("conversion")][c];
      if (frame.cells.born[c] == frame.step && frame.cells.id[c] != 0) {
        EXPECT_TRUE(std::isnan(conversion));
        EXPECT_TRUE(std::isnan(frame.cells.inputs[4][c]));
        ++newborn;
        continue;
      }
      EXPECT_EQ(conversion, 0.5f * model::test::noise(frame.cells.id[c], frame.step, 4));
      EXPECT_GE(frame.cells.inputs[4][c], 0);
      ++old;
    }
  EXPECT_GT(newborn, 10u);
  EXPECT_GT(old, 100u);
}

TEST_F(Recorded, StridesChooseStepsAndNeverMissTheLast) {
  Bench bench;
  test::set_up(bench, 26);
  const Recording sparse =
      test::record(bench, {.every = 4, .fields_every = 6, .controller = false});
  std::vector<std::uint64_t> steps, with_fields;
  for (const Frame& frame : sparse.frames) {
    steps.push_back(frame.step);
    if (frame.has_fields) with_fields.push_back(frame.step);
    EXPECT_EQ(frame.grids.size(), frame.has_fields ? 1u : 0u);
    EXPECT_TRUE(frame.cells.outputs.empty());
  }
  EXPECT_EQ(steps, (std::vector<std::uint64_t>{0, 4, 8, 12, 16, 20, 24, 25}));
  EXPECT_EQ(with_fields, (std::vector<std::uint64_t>{0, 12, 24, 25}));
  EXPECT_EQ(sparse.summaries.size(), 26u);
  EXPECT_EQ(sparse.ending.steps, 26u);
}

TEST(Recorder, TellsOfWounds) {
  Bench bench;
  test::set_up(bench, 40);
  Simulation& simulation = bench.start();
  bench.steps(20);
  Collector collector;
  Recorder recorder(bench.ecosystem(), 0, collector);
  simulation.tell(&recorder);
  const std::uint32_t removed = simulation.wound({.x = 0, .y = 0, .radius = 2});
  ASSERT_GT(removed, 0u);
  EXPECT_EQ(collector.recording().header.first_step, 20u);
  ASSERT_EQ(collector.recording().events.size(), removed);
  EXPECT_EQ(collector.recording().events[0].kind, EventKind::death);
  EXPECT_EQ(collector.recording().events[0].cause, none);
  EXPECT_EQ(collector.recording().events[0].step, 20u);
}

TEST(Recorder, RefusesAStrideOfZero) {
  Bench bench;
  bench.start();
  Collector collector;
  EXPECT_THROW(Recorder(bench.ecosystem(), 0, collector, {}, {.every = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace somas::recording
