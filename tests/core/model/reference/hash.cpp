// The hash of a world (core/model/hash.cpp), from one string of bytes.
#define XXH_INLINE_ALL
#include <algorithm>
#include <xxhash.h>

#include "tests/core/model/reference/life.hpp"

namespace somas::reference {

namespace {

class Bytes {
 public:
  template <class T>
  void add(T value) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof value);
  }
  template <class T>
  void add_all(const std::vector<T>& values) {
    add(std::uint64_t{values.size()});
    for (const T value : values) add(value);
  }
  [[nodiscard]] std::uint64_t hash() const { return XXH3_64bits(bytes_.data(), bytes_.size()); }

 private:
  std::vector<unsigned char> bytes_;
};

/// One number of every cell.
template <class Number>
void add_column(const World& world, Number&& number, Bytes& bytes) {
  for (const Cell& cell : world.cells) bytes.add(number(cell));
}

void add_cells(const World& world, Bytes& bytes) {
  const auto column = [&](auto number) { add_column(world, number, bytes); };
  for (double Cell::*member :
       {&Cell::x, &Cell::y, &Cell::vx, &Cell::vy, &Cell::radius, &Cell::energy, &Cell::ambrosia,
        &Cell::pressure, &Cell::stress_xx, &Cell::stress_xy, &Cell::stress_yy})
    column([&](const Cell& cell) { return cell.*member; });
  column([](const Cell& cell) { return cell.name.id; });
  column([](const Cell& cell) { return cell.parent; });
  column([](const Cell& cell) { return cell.born; });
  column([](const Cell& cell) { return cell.remaining; });
  column([](const Cell& cell) { return cell.cause; });
  column([](const Cell& cell) { return cell.name.organism; });
  column([](const Cell& cell) { return cell.state; });
  column([](const Cell& cell) { return cell.target; });
  column([](const Cell& cell) { return cell.action; });
  column([](const Cell& cell) { return static_cast<std::uint8_t>(cell.dead ? 1 : 0); });
  if (world.cells.empty()) return;
  const Cell& any = world.cells.front();
  for (std::size_t v = 0; v < any.values.size(); ++v)
    column([&](const Cell& cell) { return cell.values[v]; });
  for (std::size_t h = 0; h < any.damage.size(); ++h)
    column([&](const Cell& cell) { return cell.damage[h]; });
  for (std::size_t row = 0; row < any.memory.size(); ++row)
    column([&](const Cell& cell) { return cell.memory[row]; });
}

void add_contacts(const World& world, Bytes& bytes) {
  for (const Cell& cell : world.cells) {
    std::vector<std::uint32_t> places;
    for (std::uint32_t k = 0; k < world.cells.size(); ++k)
      if (std::binary_search(cell.contacts.begin(), cell.contacts.end(), world.cells[k].name))
        places.push_back(k);
    bytes.add_all(places);
  }
}

/// A field with two rows and columns of zeros round it.
std::vector<float> padded(const Field& field) {
  std::vector<float> squares;
  for (std::int64_t row = -2; row < field.size + 2; ++row)
    for (std::int64_t column = -2; column < field.size + 2; ++column)
      squares.push_back(field.at(column, row));
  return squares;
}

}  // namespace

std::uint64_t hash_of(const World& world) {
  Bytes bytes;
  bytes.add(world.seed);
  bytes.add(world.step);
  bytes.add(std::uint64_t{world.cells.size()});
  add_cells(world, bytes);
  add_contacts(world, bytes);
  for (const Organism& organism : world.organisms) {
    bytes.add(organism.key);
    bytes.add(organism.next_id);
    for (const Field& field : organism.fields) bytes.add_all(padded(field));
  }
  for (const std::vector<double>& grid : world.grids) bytes.add_all(grid);
  for (const PlainTable& table : world.tables)
    for (const std::vector<double>& column : table.columns) bytes.add_all(column);
  bytes.add_all(world.scalars);
  for (std::size_t p = 0; p < world.parameters.size(); ++p)
    if (!world.schema().parameters[p].in_charge.empty())
      bytes.add_all(std::vector<double>{world.parameters[p]});
  return bytes.hash();
}

}  // namespace somas::reference
