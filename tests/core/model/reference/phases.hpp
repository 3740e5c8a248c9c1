// The phases of a step (docs/model.md, section 0), each a function of the world.
#pragma once

#include <vector>

#include "tests/core/model/reference/world.hpp"

namespace somas::reference {

// plugins.cpp
/// Calls `begin` of every environment.
void begin_environments(World& world);
/// Calls the environments that act in a phase; forces are summed into the cells' force_x, force_y.
void act(Phase phase, World& world);
/// Asks the fitness whether to stop.
[[nodiscard]] bool observe(World& world);
/// One step of every controller; in step 0 warm-up before.
void control(World& world);

// metabolism.cpp
void take_up(World& world);
void convert(World& world);
void diffuse(World& world);
void pay(World& world);

// cycle.cpp
void decide(World& world);
/// Actions advance and take effect. Returns the newborn, which are not yet in the world.
[[nodiscard]] std::vector<Cell> advance(World& world);

// mechanics.cpp
void move(World& world);

}  // namespace somas::reference
