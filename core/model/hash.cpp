// The hash of a world: storage order, caches and wall-clock play no part in it.
#define XXH_INLINE_ALL
#include <cstring>
#include <memory>
#include <xxhash.h>

#include "core/model/simulation.hpp"

namespace somas::model {

namespace {

class Hasher {
 public:
  Hasher() : state_(XXH3_createState(), &XXH3_freeState) { XXH3_64bits_reset(state_.get()); }

  template <class T>
  void add(std::span<const T> values) {
    add(static_cast<std::uint64_t>(values.size()));
    XXH3_64bits_update(state_.get(), values.data(), values.size_bytes());
  }
  void add(std::uint64_t value) { XXH3_64bits_update(state_.get(), &value, sizeof value); }

  /// A column in canonical order.
  template <class T>
  void column(std::span<const T> values, std::span<const std::uint32_t> order) {
    buffer_.resize(order.size() * sizeof(T));
    for (std::size_t k = 0; k < order.size(); ++k)
      std::memcpy(buffer_.data() + k * sizeof(T), &values[order[k]], sizeof(T));
    XXH3_64bits_update(state_.get(), buffer_.data(), buffer_.size());
  }

  [[nodiscard]] std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
  std::vector<unsigned char> buffer_;
};

}  // namespace

std::uint64_t Simulation::hash() const {
  Hasher hasher;
  hasher.add(state_.seed);
  hasher.add(state_.step);
  const CellStore& cells = state_.cells;
  hasher.add(std::uint64_t{cells.size()});
  cells.each_column([&](const auto& column) { hasher.column(std::span(column), cells.order); });
  for (std::uint32_t c = 0; c < cells.memory.channels(); ++c)
    hasher.column(std::span(cells.memory.row(c), cells.size()), cells.order);

  // Contacts by rank.
  std::vector<std::uint32_t> ranks;
  for (const std::uint32_t i : cells.order) {
    ranks.clear();
    for (const std::uint32_t j : state_.contacts.of(i)) ranks.push_back(cells.rank[j]);
    hasher.add(std::span<const std::uint32_t>(ranks));
  }
  for (const OrganismState& organism : state_.organisms) {
    hasher.add(organism.key);
    hasher.add(organism.next_id);
    for (std::size_t kind = 0; kind < organism.fields.kinds(); ++kind)
      hasher.add(organism.fields.raw(kind));
  }
  for (const auto& grid : state_.grids) hasher.add(std::span<const double>(grid));
  for (const TableStore& table : state_.tables)
    for (Id c = 0; c < table.columns(); ++c) hasher.add(table.column(c));
  hasher.add(std::span<const double>(state_.scalars));
  // The others are what the experiment says.
  for (std::size_t p = 0; p < state_.parameters.size(); ++p)
    if (!ecosystem_.schema().parameters[p].in_charge.empty())
      hasher.add(std::span<const double>(&state_.parameters[p], 1));
  return hasher.digest();
}

}  // namespace somas::model
