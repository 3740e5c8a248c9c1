#include "core/model/mechanics.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/model/ranges.hpp"

namespace somas::model {

namespace {

/// Bodies of different islands cannot touch as long as each moves less than this in a step.
constexpr double free_way = 1.0;
constexpr unsigned steps_after_escape = 16;

}  // namespace

double rest_distance(const State& state) {
  const double springs = state.stiffness + state.adhesion;
  if (springs == 0) return 2.0 * state.radius;
  return (state.stiffness * 2.0 * state.radius + state.adhesion * state.radius) / springs;
}

void MechanicsSolver::use(Team* team) {
  team_ = team;
  whole_.use(team);
  islands_.use(team);
  bins_.use(team);
}

void MechanicsSolver::run(const Mechanics& constants, WorldState& world,
                          const ExternalForces& external) {
  CellStore& cells = world.cells;
  table_.prepare(world);
  motility_.prepare(world);
  // Environments look at all cells in each substep. And who has gone far may do so again.
  if (steps_as_whole_ > 0) --steps_as_whole_;
  by_island_ = !external && steps_as_whole_ == 0 && list_blocks(cells);
  if (by_island_) {
    place(cells);
    load(world);
    load_external(external, cells);
    by_island_ = run_blocks(constants, world);
    if (!by_island_) steps_as_whole_ = steps_after_escape;
  }
  if (!by_island_) run_whole(constants, world, external);
  store(cells);
  store_stresses(constants.pressure_scale, cells);
  binned_ = false;
  remains_ = cell_;
}

/// Everybody at once, in canonical order.
void MechanicsSolver::run_whole(const Mechanics& constants, WorldState& world,
                                const ExternalForces& external) {
  CellStore& cells = world.cells;
  cell_ = cells.order;
  place_of_ = cells.rank;
  load(world);
  whole_.begin(constants, table_, world, {0, bodies_, stress_, cell_});
  for (std::uint32_t s = 0; s < constants.substeps; ++s) {
    if (external && s > 0) store(cells);
    if (external || s == 0) load_external(external, cells);
    whole_.move(external_);
  }
  take_pieces(1);
  pieces_[0].places = {0, cells.size()};
  whole_.finish(pieces_[0].touching);
}

/// Whether cells fall into blocks that cannot touch each other within a step, and none is so large
/// that threads would wait for the one that has it.
bool MechanicsSolver::list_blocks(const CellStore& cells) {
  const std::uint32_t count = cells.size();
  if (count < least_by_island_) return false;
  double widest = 0;
  for (const double radius : cells.radius) widest = std::max(widest, radius);
  const Sites sites{cells.x, cells.y, cells.order};
  if (!islands_.number(sites, 2.0 * (table_.range() * widest + free_way), number_)) return false;
  // Small islands share a block: each costs a little of its own.
  const std::uint32_t least = least_by_island_ / 16;
  block_start_.assign(1, 0);
  std::uint32_t largest = 0;
  for (const std::uint32_t end : islands_.starts().subspan(1)) {
    const std::uint32_t size = end - block_start_.back();
    if (size < least && end < count) continue;
    largest = std::max(largest, size);
    block_start_.push_back(end);
  }
  const unsigned parts = team_ == nullptr ? 1 : team_->parts(count);
  return parts == 1 || largest <= count / (2 * parts);
}

/// By island.
void MechanicsSolver::place(const CellStore& cells) {
  cell_.resize(cells.size());
  place_of_.resize(cells.size());
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = cells.order[k];
      place_of_[i] = number_[k];
      cell_[number_[k]] = i;
    }
  });
}

/// A solver that nobody uses; of so many pieces the same one each time, where that can be.
MechanicsSolver::Borrowed MechanicsSolver::free_solver(unsigned piece, unsigned pieces) {
  const std::size_t solvers = block_solvers_.size();
  for (std::size_t s = solvers * piece / pieces;; s = (s + 1) % solvers)
    if (!block_solvers_[s].busy.exchange(true, std::memory_order_acquire))
      return Borrowed(&block_solvers_[s]);
}

void MechanicsSolver::take_pieces(unsigned pieces) {
  if (pieces_.size() < pieces) pieces_.resize(pieces);
  taken_ = pieces;
  for (Piece& piece : std::span(pieces_).first(pieces)) piece.touching.count = 0;
}

/// Block after block through all substeps, so that all of it stays in a near cache. Returns false
/// where somebody has gone so far that it may have met another block: then all that came of it
/// counts for nothing.
bool MechanicsSolver::run_blocks(const Mechanics& constants, const WorldState& world) {
  const std::uint32_t count = world.cells.size();
  take_pieces(team_ == nullptr ? 1 : team_->pieces(count));
  const std::size_t threads = team_ == nullptr ? 1 : team_->threads();
  if (block_solvers_.size() < threads) block_solvers_ = std::vector<BlockSolver>(threads);
  const auto run_some = [&](unsigned p) {
    const Stretch own = stretch(count, p, taken_);
    auto block = std::ranges::lower_bound(block_start_, own.begin);
    Piece& piece = pieces_[p];
    piece.places.begin = *block;
    piece.escaped = false;
    const Borrowed borrowed = free_solver(p, taken_);
    for (; *block < own.end && !piece.escaped; ++block)
      piece.escaped =
          !run_block(constants, world, {block[0], block[1]}, borrowed->solver, piece.touching);
    piece.places.end = *block;
  };
  run_parts(team_, taken_, run_some);
  return std::none_of(pieces_.begin(), pieces_.begin() + taken_,
                      [](const Piece& piece) { return piece.escaped; });
}

/// Returns false where somebody has gone too far.
bool MechanicsSolver::run_block(const Mechanics& constants, const WorldState& world, Stretch block,
                                SpringSolver& solver, Touching& touching) {
  const std::uint32_t size = block.end - block.begin;
  const auto external = external_.empty()
                            ? std::span<const Two>{}
                            : std::span<const Two>(external_).subspan(block.begin, size);
  solver.begin(
      constants, table_, world,
      {block.begin, std::span(bodies_).subspan(block.begin, size),
       std::span(stress_).subspan(block.begin, size), std::span(cell_).subspan(block.begin, size)});
  for (std::uint32_t s = 0; s < constants.substeps; ++s)
    if (solver.move(external) && gone_far(world.cells, block)) return false;
  solver.finish(touching);
  return true;
}

/// Whether a body has left its surroundings, or may do so before pairs are found anew. It started
/// where its cell still is in storage.
bool MechanicsSolver::gone_far(const CellStore& cells, Stretch block) const {
  const double free = free_way - SpringSolver::longest_drift();
  for (std::uint32_t k = block.begin; k < block.end; ++k) {
    const double dx = bodies_[k].x - cells.x[cell_[k]], dy = bodies_[k].y - cells.y[cell_[k]];
    if (!(dx * dx + dy * dy < free * free)) return true;
  }
  return false;
}

void MechanicsSolver::load(const WorldState& world) {
  const CellStore& cells = world.cells;
  bodies_.resize(cells.size());
  stress_.resize(cells.size());
  share_ranges(team_, cells, [&](const CellRange& range) {
    const double inverse_mass = 1.0 / world.state_of(range.begin).mass;
    const std::uint32_t kind = table_.kind(range.organism, range.state);
    for (std::uint32_t i = range.begin; i < range.end; ++i)
      bodies_[place_of_[i]] = {cells.x[i],      cells.y[i],   cells.vx[i], cells.vy[i],
                               cells.radius[i], inverse_mass, kind};
  });
}

void MechanicsSolver::load_external(const ExternalForces& external, const CellStore& cells) {
  external_.clear();
  if (!external && motility_.resting()) return;
  external_x_.assign(bodies_.size(), 0.0);
  external_y_.assign(bodies_.size(), 0.0);
  if (external) external(external_x_, external_y_);
  motility_.add(external_x_, external_y_);
  external_.resize(bodies_.size());
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t k = begin; k < end; ++k)
      external_[k] = Two{external_x_[cell_[k]], external_y_[cell_[k]]};
  });
}

void MechanicsSolver::store(CellStore& cells) const {
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const Body& body = bodies_[place_of_[i]];
      cells.x[i] = body.x;
      cells.y[i] = body.y;
      cells.vx[i] = body.vx;
      cells.vy[i] = body.vy;
    }
  });
}

void MechanicsSolver::store_stresses(double pressure_scale, CellStore& cells) const {
  share(team_, cells.size(), [&](std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const Four stress = stress_[place_of_[i]];
      cells.pressure[i] = stress[0] / (stress[0] + pressure_scale);
      cells.stress_xx[i] = stress[1];
      cells.stress_xy[i] = stress[2];
      cells.stress_yy[i] = stress[3];
    }
  });
}

const DiscBins& MechanicsSolver::bins() {
  if (!by_island_) return whole_.bins();
  if (std::exchange(binned_, true)) return bins_;
  discs_.resize(bodies_.size());
  share(team_, static_cast<std::uint32_t>(bodies_.size()),
        [&](std::uint32_t begin, std::uint32_t end) {
          for (std::uint32_t k = begin; k < end; ++k)
            discs_[k] = {bodies_[k].x, bodies_[k].y, bodies_[k].radius, 0};
        });
  bins_.sort(discs_, 1);
  return bins_;
}

void MechanicsSolver::list_contacts(Contacts& contacts, std::span<const std::uint32_t> new_index) {
  const auto places = static_cast<std::uint32_t>(remains_.size());
  if (!new_index.empty())
    share(team_, places, [&](std::uint32_t begin, std::uint32_t end) {
      for (std::uint32_t& cell : std::span(remains_).subspan(begin, end - begin))
        cell = new_index[cell];
    });
  const bool some_lost = !new_index.empty();
  const auto lost = some_lost ? std::count(remains_.begin(), remains_.end(), gone) : 0;
  contacts.runs.resize(places - static_cast<std::size_t>(lost));
  if (!by_island_ && whole_.in_parts()) return list_contacts_in_parts(contacts);
  // No two pieces have the same cells.
  if (lost > 0) {
    const auto drop_some = [this](unsigned p) { drop_lost(pieces_[p].touching); };
    run_parts(team_, taken_, drop_some);
  }
  std::uint32_t items = 0;
  for (Piece& piece : std::span(pieces_).first(taken_)) {
    piece.first_item = items;
    items += 2 * static_cast<std::uint32_t>(piece.touching.count);
  }
  contacts.items.resize(items);
  next_lower_.resize(places);
  higher_.resize(places);
  const auto list_some = [&](unsigned p) { list_contacts(pieces_[p], contacts); };
  run_parts(team_, taken_, list_some);
}

/// Keeps the pairs of which both cells remain.
void MechanicsSolver::drop_lost(Touching& touching) const {
  Touching::Pair* const pairs = touching.pairs.data();
  const std::uint32_t* const remains = remains_.data();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < touching.count; ++t) {
    const Touching::Pair pair = pairs[t];
    pairs[kept] = pair;
    kept += std::size_t{remains[pair.first] != gone} & std::size_t{remains[pair.second] != gone};
  }
  touching.count = kept;
}

/// Counts, then places: pair after pair, so each cell's contacts come in canonical order, the lower
/// before the higher. How many a cell has is hard to foretell: nothing branches on it.
void MechanicsSolver::list_contacts(const Piece& piece, Contacts& contacts) {
  const auto count = static_cast<std::uint32_t>(piece.touching.count);
  const Touching::Pair* const pairs = piece.touching.pairs.data();
  const std::uint32_t* const remains = remains_.data();
  std::uint32_t *const lower = next_lower_.data(), *const higher = higher_.data();
  std::fill(lower + piece.places.begin, lower + piece.places.end, 0u);
  std::fill(higher + piece.places.begin, higher + piece.places.end, 0u);
  // Pairs with the same first follow each other: it is enough to know where they end.
  for (std::uint32_t t = 0; t < count; ++t) {
    higher[pairs[t].first] = t + 1;
    ++lower[pairs[t].second];
  }
  std::uint32_t next = piece.first_item, before = 0;
  for (std::uint32_t k = piece.places.begin; k < piece.places.end; ++k) {
    const std::uint32_t begin = next, middle = begin + std::exchange(lower[k], begin);
    const std::uint32_t end = std::max(before, higher[k]);
    next = middle + (end - before);
    higher[k] = middle - before;
    before = end;
    if (remains[k] != gone) contacts.runs[remains[k]] = {begin, next};
  }
  std::uint32_t* const items = contacts.items.data();
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto [a, b] = pairs[t];
    items[higher[a] + t] = remains[b];
    items[lower[b]++] = remains[a];
  }
}

/// Calls visit(index) for the contacts of a cell that remain, in canonical order.
template <class Visit>
void MechanicsSolver::each_contact(std::uint32_t place, Visit&& visit) const {
  whole_.each_contact(place, [&](std::uint32_t other) {
    if (remains_[other] != gone) visit(remains_[other]);
  });
}

void MechanicsSolver::list_contacts_in_parts(Contacts& contacts) {
  const auto places = static_cast<std::uint32_t>(remains_.size());
  take_pieces(team_->pieces(places));
  const auto each_place = [&](unsigned p, auto&& visit) {
    const Stretch own = stretch(places, p, taken_);
    for (std::uint32_t k = own.begin; k < own.end; ++k)
      if (remains_[k] != gone) visit(k);
  };
  const auto count = [&](unsigned p) {
    std::uint32_t all = 0;
    each_place(p, [&](std::uint32_t k) { each_contact(k, [&](std::uint32_t) { ++all; }); });
    pieces_[p].first_item = all;
  };
  team_->run(taken_, count);
  std::uint32_t items = 0;
  for (Piece& piece : std::span(pieces_).first(taken_))
    items += std::exchange(piece.first_item, items);
  contacts.items.resize(items);
  const auto list = [&](unsigned p) {
    std::uint32_t next = pieces_[p].first_item;
    each_place(p, [&](std::uint32_t k) {
      const std::uint32_t begin = next;
      each_contact(k, [&](std::uint32_t other) { contacts.items[next++] = other; });
      contacts.runs[remains_[k]] = {begin, next};
    });
  };
  team_->run(taken_, list);
}

}  // namespace somas::model
