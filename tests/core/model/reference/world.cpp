#include "tests/core/model/reference/world.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace somas::reference {

void Sum::add(double x) {
  const double next = sum + x;
  if (std::abs(sum) >= std::abs(x))
    error += (sum - next) + x;
  else
    error += (x - next) + sum;
  sum = next;
}

void Events::add(const Events& other) {
  steps += other.steps, cell_steps += other.cell_steps;
  births += other.births, specializations += other.specializations;
  refused_divisions += other.refused_divisions;
  gifts += other.gifts, gifts_to_strangers += other.gifts_to_strangers;
  shrunk_gifts += other.shrunk_gifts, legacies += other.legacies;
  scarce_demands += other.scarce_demands, crowded_rooms += other.crowded_rooms;
  coincident_pairs += other.coincident_pairs;
  stranger_touches += other.stranger_touches, stranger_contacts += other.stranger_contacts;
  crawls += other.crawls, forces_from_outside += other.forces_from_outside, hits += other.hits,
      random_axes += other.random_axes;
  for (const auto& [cause, count] : other.deaths) deaths[cause] += count;
}

Cell& World::find(const Name& name) {
  return *std::lower_bound(cells.begin(), cells.end(), name,
                           [](const Cell& cell, const Name& n) { return cell.name < n; });
}

std::vector<std::size_t> World::seen_order() const {
  std::vector<std::size_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(cells[a].name.organism, cells[a].state, cells[a].name.id) <
           std::tuple(cells[b].name.organism, cells[b].state, cells[b].name.id);
  });
  return order;
}

std::vector<std::size_t> World::booking_order() const {
  if (mistake != Mistake::books_by_name) return seen_order();
  std::vector<std::size_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

double share(float output) {
  if (std::isnan(output)) return 0.0;
  return std::clamp(static_cast<double>(output), 0.0, 1.0);
}

}  // namespace somas::reference
