// What a picture shows of a world: taken from a simulation between two steps, or from a frame of a
// recording, and kept until it is drawn. Lengths are those of the model (a founder's radius is 1).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/model/simulation.hpp"
#include "core/recording/recording.hpp"

namespace somas::report {

/// A cell as it was.
struct SceneCell {
  double x = 0, y = 0, radius = 0;
  double energy = 0;
  std::uint16_t state = 0;     ///< index into the setting's states
  std::uint16_t organism = 0;  ///< index into the setting's organisms
  bool dividing = false;
};

/// A world after one step, as far as it is drawn.
struct Scene {
  std::uint64_t step = 0;
  std::vector<SceneCell> cells;                ///< in canonical order: by organism
  std::vector<std::uint32_t> counts;           ///< cells by state
  std::vector<std::vector<Point>> tables;      ///< rows, by table drawn
  std::vector<double> grid;                    ///< content, row-major; empty without a grid
  std::vector<std::vector<float>> sensed;      ///< concentration at the cell, by morphogen, cell
  std::vector<std::vector<float>> morphogens;  ///< by morphogen, row-major; of one organism

  [[nodiscard]] std::uint32_t dividing() const;
};

/// What a scene needs besides its cells.
struct SceneWants {
  std::string grid = {};     ///< "instance.name"; empty: the first there is; "none"
  bool morphogens = false;   ///< sensed, and on their grid
  std::size_t organism = 0;  ///< place in the roster of the one that it is about
};

/// What all scenes of a life have in common, read from what the experiment declared: environments
/// that nobody has seen before show up, too.
struct Setting {
  struct PositionColumns {
    Id table, x, y;
  };
  double radius = 0;                   ///< of the world
  std::vector<std::string> states;     ///< names; the tree's order
  std::vector<std::string> organisms;  ///< "organism 1 (the champion)"; several only
  std::vector<std::string> tables;     ///< names of those with columns x and y
  std::vector<PositionColumns> position_columns;
  std::vector<recording::Outline> outlines;
  Id grid = no_id;  ///< the one that is drawn
  std::string grid_name;
  GridSpec grid_spec;
  std::size_t morphogens = 0;  ///< kinds
  GridSpec morphogen_spec;
};

/// Throws run::UsageError, naming the grids, for one that is absent. `wants` says which organism is
/// the champion.
[[nodiscard]] Setting setting_of(const recording::Header& header, const SceneWants& wants);
[[nodiscard]] Setting setting_of(const model::Simulation& simulation, const SceneWants& wants);

[[nodiscard]] Scene scene_of(const model::Simulation& simulation, const Setting& setting,
                             const SceneWants& wants);
/// Of a frame without fields: no grid, no morphogens.
[[nodiscard]] Scene scene_of(const recording::Header& header, const recording::Frame& frame,
                             const Setting& setting, const SceneWants& wants);

/// Where a resource ever was: the squares of the grids that cells feed on that held anything at any
/// step seen. Nothing to show where that is all of the world.
class Zones {
 public:
  struct Zone {
    std::string resource;
    GridSpec spec;
    std::vector<std::uint8_t> squares;  ///< 1: held something; row-major
    bool everywhere = false;            ///< all squares whose centre lies in the world
  };
  /// Call after every step.
  void observe(const model::Simulation& simulation);
  /// Or with every frame.
  void observe(const recording::Header& header, const recording::Frame& frame);
  [[nodiscard]] const std::vector<Zone>& zones() const { return zones_; }

 private:
  void begin(const recording::Header& header);
  template <class Contents>
  void look(const Contents& grids, double radius);

  std::vector<Zone> zones_;
  std::vector<std::size_t> grids_;  ///< of the zones
  bool begun_ = false;
};

}  // namespace somas::report
