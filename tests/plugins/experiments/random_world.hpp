// Experiments drawn at random, out of all bundled plugins: small worlds in which living is cheap.
#pragma once

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "somas/sdk/rng.hpp"

#include "core/model/ecosystem.hpp"

namespace somas::test {

/// Draws an experiment file. Equal seeds give equal text.
class RandomWorld {
 public:
  explicit RandomWorld(std::uint64_t seed)
      : rng_(seed, 0, 0, stable_key("random_world"), 0), radius_(between(8, 30)) {
    yaml_ << "somas: 1\n";
    choose_environments();
    write_specialization();  // before the world: the stiffest state limits the time step
    write_world();
    write_environments();
    yaml_ << "controller: {plugin: " << (chance(0.5) ? "grn" : "ctrnn") << "}\n";
    yaml_ << "fitness: {plugin: " << (chance(0.5) ? "survival_time" : "competition") << "}\n";
  }

  [[nodiscard]] std::string text() const { return yaml_.str(); }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  double between(double low, double high) { return rng_.uniform(low, high); }
  std::uint64_t whole(std::uint64_t low, std::uint64_t high) {
    return low + rng_.below(high - low + 1);
  }
  bool chance(double p) { return rng_.chance(p); }

  void choose_environments() {
    nutrients_ = chance(0.5), cyclic_ = chance(0.3);
    two_ = chance(0.3) || !(nutrients_ || cyclic_);
    particles_ = chance(0.5), toxin_ = chance(0.3), walls_ = chance(0.3);
    seasons_ = chance(0.4);
  }

  void write_specialization() {
    if (chance(0.25)) {
      write_evolved_tree();
    } else {
      write_fixed_tree();
    }
  }

  void write_evolved_tree() {
    stiffness_ = between(2, 15), adhesion_ = between(0, 5), mass_ = between(0.7, 1.5);
    const double most_adhesion = adhesion_ + between(0, 3);
    yaml_ << "specialization:\n  plugin: evolved_tree\n  budget: " << between(8, 30)
          << "\n  evolve_motility: true\n  evolve_adhesion: true\n  evolve_thresholds: "
          << (chance(0.5) ? "true" : "false") << "\n  max_adhesion: " << most_adhesion
          << "\n  mass: " << mass_ << "\n  radius: " << between(0.6, 1.3)
          << "\n  stiffness: " << stiffness_ << "\n  adhesion: " << adhesion_
          << "\n  adhesion_range: " << between(1, 1.4) << "\n";
    adhesion_ = most_adhesion;
  }

  void write_fixed_tree() {
    const std::uint64_t states = whole(1, 4);
    const bool alike = chance(0.3);  // one spring for all
    yaml_ << "specialization:\n  plugin: tree\n  states:\n";
    double stiffness = 0, adhesion = 0, mass = 1, range = 1.2;
    for (std::uint64_t s = 0; s < states; ++s) {
      if (s == 0 || !alike) {
        stiffness = between(0, 15), adhesion = chance(0.2) ? 0 : between(0, 5);
        mass = between(0.7, 1.5), range = between(1, 1.4);
      }
      stiffness_ = std::max(stiffness_, stiffness), adhesion_ = std::max(adhesion_, adhesion);
      mass_ = s == 0 ? mass : std::min(mass_, mass);
      yaml_ << "    - name: s" << s << "\n";
      if (s > 0) yaml_ << "      parent: s" << rng_.below(s) << "\n";
      yaml_ << "      mass: " << mass << "\n      radius: " << between(0.6, 1.3)
            << "\n      stiffness: " << stiffness << "\n      adhesion: " << adhesion
            << "\n      adhesion_range: " << range << "\n";
      if (chance(0.4))
        yaml_ << "      motility: " << between(-2, 2) << "\n      motility_signal: 0\n";
      if (chance(0.3))
        yaml_ << "      division_threshold: " << between(0, 1)
              << "\n      specialization_threshold: " << between(0, 0.6)
              << "\n      quiescence_threshold: " << between(0, 0.6)
              << "\n      apoptosis_threshold: " << between(0, 1) << "\n";
      write_skills();
    }
    if (states < 2 || alike || !chance(0.5)) return;
    const double strength = between(0, 5);
    adhesion_ = std::max(adhesion_, strength);
    yaml_ << "  adhesion_pairs: [{first: s0, second: s1, strength: " << strength << "}]\n";
  }

  void write_skills() {
    yaml_ << "      skills: {capacity: " << between(0.5, 12) << ", diffusion: " << between(0, 1)
          << ", energy_efficiency: " << between(0.5, 1);
    if (nutrients_) yaml_ << ", production: " << between(0.2, 3);
    if (cyclic_) yaml_ << ", foraging: " << between(0.2, 3);
    if (two_) yaml_ << ", production_a: " << between(0, 3) << ", production_b: " << between(0.2, 3);
    if (particles_) yaml_ << ", resistance: " << between(0, 6);
    if (toxin_) yaml_ << ", toxin_resistance: " << between(0, 4);
    yaml_ << "}\n";
  }

  void write_world() {
    const double damping = between(0, 5), drag = between(0.1, 2);
    const double limit = model::stable_time_step(stiffness_, adhesion_, mass_, damping, drag);
    yaml_ << "world:\n  radius: " << radius_ << "\n  max_steps: " << whole(40, 2000)
          << "\n  max_cells: " << whole(6, 60) << "\n  warm_up_steps: " << whole(0, 30) << "\n";
    yaml_ << "  mechanics: {substeps: " << whole(1, 5)
          << ", time_step: " << std::min(0.05, limit) * between(0.3, 0.99)
          << ", damping: " << damping << ", drag: " << drag
          << ", pressure_scale: " << between(1, 20) << "}\n";
    yaml_ << "  metabolism: {quiescence_cost: " << between(0, 0.03)
          << ", division_cost: " << between(0, 0.08) << ", apoptosis_cost: " << between(0, 0.05)
          << ", specialization_cost: " << between(0, 0.05)
          << ", motility_cost: " << between(0, 0.01) << ", founder_ambrosia: " << between(0, 10)
          << ", founder_energy: " << between(0.5, 1) << "}\n";
    yaml_ << "  strangers: {adhere: " << (chance(0.5) ? "true" : "false")
          << ", feed: " << (chance(0.6) ? "true" : "false") << "}\n";
    yaml_ << "  cycle: {quiescence_steps: " << whole(1, 5) << ", division_steps: " << whole(1, 8)
          << ", apoptosis_steps: " << whole(1, 8) << ", specialization_steps: " << whole(1, 8)
          << ", division_energy: " << between(0, 0.6) << ", division_pressure: " << between(0.3, 1)
          << "}\n";
    yaml_ << "  morphogens:\n    size: " << 2 * whole(0, 16) + 1
          << "\n    side: " << between(0.7, 3)
          << "\n    deposit: " << (chance(0.5) ? "peak" : "share") << "\n    kinds:\n";
    for (std::uint64_t kinds = whole(1, 4); kinds > 0; --kinds)
      yaml_ << "      - {attenuation: " << edge_or_between()
            << ", evaporation: " << edge_or_between() << "}\n";
  }

  /// In [0, 1], the ends now and then.
  double edge_or_between() {
    if (chance(0.1)) return chance(0.5) ? 0 : 1;
    return between(0, 0.3);
  }

  void write_environments() {
    yaml_ << "environments:\n";
    if (nutrients_) {
      yaml_ << "  nutrients:\n    capacity: " << between(0.5, 3)
            << "\n    regeneration: " << between(0.01, 0.3) << "\n";
      write_grid();
      if (chance(0.3)) yaml_ << "    region: disc\n    radius: " << between(3, 20) << "\n";
    }
    if (cyclic_) {
      yaml_ << "  cyclic:\n    plugin: cyclic_nutrients\n    production_skill: foraging\n    "
               "capacity: "
            << between(0.5, 3) << "\n    regeneration: " << between(0.01, 0.3)
            << "\n    half_side: " << between(4, 14) << "\n    present: " << whole(5, 40)
            << "\n    first_gap: " << between(1, 8) << "\n";
      write_grid();
    }
    if (two_) {
      yaml_ << "  two_nutrients:\n    capacity: " << between(0.5, 6)
            << "\n    yield: " << between(0, 1) << "\n    regeneration: " << between(0, 0.05)
            << "\n";
      write_grid();
    }
    if (particles_)
      yaml_ << "  particle_aggression:\n    speed: " << between(0.3, 4)
            << "\n    aim_spread: " << between(0, 6) << "\n    energy: " << between(0.2, 2)
            << "\n    start: " << whole(0, 20) << "\n    rate_scale: " << between(0, 2) << "\n";
    if (toxin_) write_toxin();
    if (walls_) write_walls();
    if (seasons_) write_seasons();
  }

  void write_grid() {
    yaml_ << "    resolution: " << whole(1, 24) << "\n    side: " << between(0.5, 4) << "\n";
  }

  void write_toxin() {
    const double side = between(1, 3);
    const std::uint64_t resolution = whole(8, 24);
    const double inside = 0.4 * side * static_cast<double>(resolution);
    const double diffusion = between(0, 0.2) * side * side;
    yaml_ << "  toxin_gradient:\n    resolution: " << resolution << "\n    side: " << side
          << "\n    diffusion: " << diffusion
          << "\n    decay: " << between(0, 1 - 4 * diffusion / (side * side))
          << "\n    boundary: " << (chance(0.5) ? "zero_flux" : "absorbing")
          << "\n    toxicity: " << between(0, 0.2)
          << "\n    sources: [{x: " << between(-inside, inside)
          << ", y: " << between(-inside, inside) << ", rate: " << between(0.5, 6) << "}]\n";
  }

  void write_walls() {
    yaml_ << "  walls:\n    stiffness: " << between(5, 30) << "\n    damping: " << between(0, 3)
          << "\n    lightest_mass: " << mass_ << "\n    obstacles:\n"
          << "      - {kind: disc, x: " << between(2, 8) << ", y: " << between(-6, 6)
          << ", radius: " << between(0.5, 3) << "}\n";
    if (chance(0.5))
      yaml_ << "      - {kind: box, x: " << between(-8, -3) << ", y: " << between(-6, 6)
            << ", half_width: " << between(0.5, 2) << ", half_height: " << between(0.5, 2) << "}\n";
    if (chance(0.5))
      yaml_ << "      - {kind: enclosure, x: 0, y: 0, half_width: " << between(8, 14)
            << ", half_height: " << between(8, 14) << "}\n";
    if (chance(0.5))
      yaml_ << "      - {kind: gap_wall, x: " << between(3, 6) << ", thickness: " << between(0.5, 2)
            << ", gap_y: 0, gap_width: " << between(2, 5) << ", half_height: 12}\n";
  }

  void write_seasons() {
    std::vector<std::string> variable;
    if (nutrients_) variable.push_back("environment: nutrients, parameter: regeneration");
    if (cyclic_) variable.push_back("environment: cyclic, parameter: regeneration");
    if (two_) variable.push_back("environment: two_nutrients, parameter: regeneration");
    if (particles_) variable.push_back("environment: particle_aggression, parameter: rate_scale");
    if (toxin_) variable.push_back("environment: toxin_gradient, parameter: toxicity");
    const char* shapes[] = {"sine", "square", "triangle", "ramp"};
    yaml_ << "  seasons:\n    cycles:\n";
    for (const std::string& what : variable)
      yaml_ << "      - {" << what << ", shape: " << shapes[rng_.below(4)]
            << ", period: " << whole(4, 60) << ", amplitude: " << between(0, 1)
            << ", phase: " << between(0, 1) << "}\n";
  }

  Rng rng_;
  std::ostringstream yaml_;
  double radius_;
  bool nutrients_ = false, cyclic_ = false, two_ = false, particles_ = false, toxin_ = false,
       walls_ = false, seasons_ = false;
  double stiffness_ = 0, adhesion_ = 0, mass_ = 1;  ///< the greatest, and the lightest
};

}  // namespace somas::test
