// A recorded life: what a simulation was, step by step, as plain data. Sinks (files, pages,
// exports) receive it piece by piece; a Recording holds all of it.
//
// Step s means the world after step s, counted from 0: what `born` says of cells, and where the
// line "step s" of a life's record stands. Organisms are numbered as in the simulation, by
// ascending key. A slot is a state of an organism: slots are the states of organism 0, then those
// of 1, ... Lengths, energy and ambrosia have the model's units (docs/model.md). Cells, grids and
// morphogens are single precision: recordings are for looking and measuring; proofs are made of
// hashes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "somas/sdk/fitness.hpp"

namespace somas::recording {

/// Of the files, and of what these structs mean.
inline constexpr std::uint32_t format_version = 1;

/// Stands for a state, a cause or an index that there is none of.
inline constexpr std::uint16_t none = 0xFFFF;

// ---- what does not change -----------------------------------------------------------------------

/// Where a recording comes from. Whoever records fills it in; nothing of it is needed to read one.
struct Provenance {
  std::string experiment{};     ///< its name
  std::string run{};            ///< name of the run directory; empty: none
  std::string version{};        ///< of SOMAS
  std::string resolved_yaml{};  ///< the experiment, every key with its value
  std::uint64_t generation = 0;
  std::uint32_t population = 0;  ///< 1 or 2; 0: there is only one
  std::uint64_t individual = 0;  ///< its id in the run
  std::string origin{};          ///< how it came to be ("mutation")
  std::vector<std::uint64_t> parents{};
  double fitness = 0;
  std::string genome_json{};
  std::vector<std::uint8_t> controller_genes{}, tree_genes{};
};

struct State {
  std::string name;
  std::uint16_t parent = none;  ///< index in the organism's tree
  double radius = 1;
  double capacity = 0;  ///< of ambrosia
};

struct Organism {
  std::uint64_t key = 0;
  std::uint32_t seat = 0;  ///< place in the roster
  std::vector<State> states;
  std::vector<std::string> outputs;  ///< the controller's, by channel
  std::uint32_t first_slot = 0;      ///< of its root state
};

/// Squares, row-major from the lower left; (left, bottom) is the grid's lower left corner.
struct Grid {
  std::string name;  ///< "instance.name"
  std::uint32_t columns = 0, rows = 0;
  double side = 1, left = 0, bottom = 0;
  std::string resource;  ///< what cells take up from it; empty: nothing

  [[nodiscard]] std::size_t squares() const { return std::size_t{columns} * rows; }
};

struct Table {
  std::string name;  ///< "instance.name"
  std::vector<std::string> columns;
};

/// A line, or the polygon that it bounds.
struct Outline {
  std::string name;  ///< "instance.name"
  std::vector<double> x, y;
  bool closed = false;
};

struct Header {
  Provenance provenance;
  std::uint64_t seed = 0;        ///< of the simulation
  double radius = 0;             ///< of the world
  std::uint64_t max_steps = 0;   ///< the life ends here at the latest
  std::uint64_t first_step = 0;  ///< greater than 0: recorded from mid-life on
  std::uint64_t every = 1;       ///< cells and tables: steps divisible by it, and the last
  std::uint64_t fields_every =
      1;                   ///< grids and morphogens: frames at steps divisible by it, and the last
  bool controller = true;  ///< whether frames have the controller's inputs and outputs
  std::uint32_t own = 0;   ///< the organism that the recording is about
  std::vector<Organism> organisms;
  std::vector<std::string> actions;  ///< names of Cells::action
  std::vector<std::string> causes;   ///< of death, names of Event::cause
  std::vector<std::string> hazards;  ///< by column of Cells::damage
  std::vector<std::string> values;   ///< "instance.name", by column of Cells::values
  std::vector<std::string> inputs;   ///< of the controller, by channel; the same for all states
  std::vector<std::string> morphogens;
  Grid morphogen_grid;
  std::vector<Grid> grids;
  std::vector<Table> tables;
  std::vector<Outline> outlines;

  [[nodiscard]] std::uint32_t slots() const {
    return organisms.empty() ? 0
                             : organisms.back().first_slot +
                                   static_cast<std::uint32_t>(organisms.back().states.size());
  }
  /// Channels of Cells::outputs: those of the organism that has most.
  [[nodiscard]] std::uint32_t output_channels() const {
    std::size_t most = 0;
    for (const Organism& organism : organisms)
      most = organism.outputs.size() > most ? organism.outputs.size() : most;
    return static_cast<std::uint32_t>(most);
  }
};

// ---- what happens -------------------------------------------------------------------------------

/// The live cells after a step, structure of arrays, by ascending (organism, id).
struct Cells {
  std::vector<std::uint32_t> id;      ///< unique within the organism, for life; the founder is 0
  std::vector<std::uint32_t> parent;  ///< id of the mother; a founder's is its own
  std::vector<std::uint32_t> born;    ///< step
  std::vector<std::uint16_t> organism, state;
  std::vector<std::uint16_t> target;  ///< state that a running specialization leads to, or none
  std::vector<std::uint8_t> action;   ///< index into Header::actions
  std::vector<float> x, y, radius, energy, ambrosia, pressure;
  std::vector<std::vector<float>> damage;  ///< absorbed so far, by hazard
  std::vector<std::vector<float>> values;  ///< declared by environments, by Header::values
  /// The controller in this step: by channel, then cell. NaN: the cell was born in it, or its tree
  /// has no such output. No channels where the recording leaves the controller out.
  std::vector<std::vector<float>> inputs, outputs;

  [[nodiscard]] std::size_t size() const { return id.size(); }
};

/// Rows of a table, by column.
struct TableRows {
  std::vector<std::vector<double>> columns;
};

struct Frame {
  std::uint64_t step = 0;
  Cells cells;
  std::vector<TableRows> tables;  ///< by Header::tables
  /// Content by Header::grids, and concentrations by organism, then morphogen, on
  /// Header::morphogen_grid. Both are empty in a frame without fields.
  bool has_fields = false;
  std::vector<std::vector<float>> grids;
  std::vector<std::vector<std::vector<float>>> morphogens;
};

enum class EventKind : std::uint8_t { birth, death, refused_division, specialization };

struct Event {
  std::uint64_t step = 0;
  EventKind kind = EventKind::birth;
  std::uint16_t organism = 0;
  std::uint32_t cell = 0;      ///< of a birth: the daughter
  std::uint32_t parent = 0;    ///< of the cell
  std::uint16_t state = 0;     ///< at the end of the event; of a specialization: the new one
  std::uint16_t from = none;   ///< of a specialization: the old state
  std::uint16_t cause = none;  ///< of a death; none: a wound
  float x = 0, y = 0;
};

/// Ambrosia that arrived, in one step, from cells of one state at cells of another: by diffusion
/// and from dying cells, before what a receiver has no room for is lost.
struct Flux {
  std::uint16_t from_organism = 0, from_state = 0, to_organism = 0, to_state = 0;
  double amount = 0;  ///< greater than 0
};

/// The world after a step in numbers; there is one of every step.
struct Summary {
  std::uint64_t step = 0;
  std::vector<std::uint32_t> population;  ///< live cells, by slot
  std::vector<double> energy, ambrosia;   ///< mean over live cells, by organism; 0 without any
  std::vector<double> grid_totals;        ///< content of squares whose centre is in the world
  std::vector<Flux> flux;                 ///< ascending; the states are those of the flow's moment
};

/// How a life ended.
struct Ending {
  std::uint64_t steps = 0;        ///< done when it ended, those before the recording included
  std::vector<Outcome> outcomes;  ///< by organism
  double score = 0;               ///< of Header::own
};

/// All of a recorded life.
struct Recording {
  Header header;
  std::vector<Frame> frames;
  std::vector<Event> events;
  std::vector<Summary> summaries;
  Ending ending;
};

}  // namespace somas::recording
