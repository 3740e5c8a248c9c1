/// @file
/// What evolves: a part whose genes the host keeps, copies, stores and hands back, without ever
/// looking inside.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "somas/sdk/extension.hpp"
#include "somas/sdk/layout.hpp"
#include "somas/sdk/rng.hpp"

namespace somas {

/// One part's genes: canonical bytes, so that equal genes are equal bytes. The length counts as
/// genome length where ties are broken by length.
using Genes = std::vector<std::uint8_t>;
/// Genes to look at, valid during the call.
using GenesView = std::span<const std::uint8_t>;

/// Writes one JSON value; host-implemented. `key` names it in the object that is open; inside a
/// list, pass an empty key. Throws on what is no JSON; let it pass.
class JsonWriter : public Extensible {
 public:
  /// What follows, up to `close`, are the members of an object.
  virtual void open_object(std::string_view key) = 0;
  /// What follows, up to `close`, are the items of a list.
  virtual void open_list(std::string_view key) = 0;
  /// Ends the object or list that was opened last.
  virtual void close() = 0;
  /// A finite number, as the shortest decimal that reads back exactly.
  virtual void number(std::string_view key, double value) = 0;
  /// A whole number.
  virtual void integer(std::string_view key, std::int64_t value) = 0;
  /// A string of UTF-8.
  virtual void text(std::string_view key, std::string_view value) = 0;
  /// A 64-bit key, as 16 hexadecimal digits (JSON numbers are doubles).
  virtual void key64(std::string_view key, std::uint64_t value) = 0;
};

/// Reads one JSON value; host-implemented. Whatever is missing or of another type throws an
/// exception that names the place; plugins let it pass.
class JsonReader : public Extensible {
 public:
  /// Whether this is an object with a member `key`.
  [[nodiscard]] virtual bool has(std::string_view key) const = 0;
  /// The member `key` of this object; valid as long as this reader.
  [[nodiscard]] virtual const JsonReader& member(std::string_view key) const = 0;
  /// How many items this list has.
  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Item `i` of this list, i < size(); valid as long as this reader.
  [[nodiscard]] virtual const JsonReader& item(std::size_t i) const = 0;
  /// This number.
  [[nodiscard]] virtual double number() const = 0;
  /// This whole number.
  [[nodiscard]] virtual std::int64_t integer() const = 0;
  /// This string; valid as long as this reader.
  [[nodiscard]] virtual std::string_view text() const = 0;
  /// These 16 hexadecimal digits, as JsonWriter::key64 writes them.
  [[nodiscard]] virtual std::uint64_t key64() const = 0;
};

/// Implemented by controllers, and by specialization trees that evolve.
///
/// All calls are const, may run concurrently on one instance, and draw chance from `rng` alone, so
/// that variation is a pure function of its arguments. Laws, checked by the host's tests: `random`
/// and `conform` give genes that fit `layout`; `mutate` of fitting genes fits, and so does `cross`;
/// `cross` of a parent with itself, or with itself after it lost ports, is that parent;
/// distance(a, a) = 0 and is symmetric; from_json(to_json(g)) equals g to the last byte.
class Heritable : public Extensible {
 public:
  /// Fresh random genes into `genes` (its old content is overwritten).
  virtual void random(const Layout& layout, Rng& rng, Genes& genes) const = 0;
  /// Makes genes of another layout fit this one: ports are matched by key, lost ones dropped, new
  /// ones drawn or, those of a new state, copied from the state above it. Leaves genes that already
  /// fit untouched.
  virtual void conform(const Layout& layout, Rng& rng, Genes& genes) const = 0;
  /// One mutation event, in place.
  virtual void mutate(const Layout& layout, Rng& rng, Genes& genes) const = 0;
  /// Offspring of two parents into `child`, whose layout this is. Where trees evolve, either parent
  /// may fit another layout: what belongs to ports that both parents have comes from either, what
  /// belongs to ports that only one has comes from that one, ports that neither has are as new ones
  /// in `conform`.
  virtual void cross(const Layout& layout, GenesView first, GenesView second, Rng& rng,
                     Genes& child) const = 0;
  /// How different two genomes are, >= 0; the scale is the part's own.
  [[nodiscard]] virtual double distance(GenesView first, GenesView second) const = 0;
  /// Members of one JSON object, for people and for exchange. Doubles survive exactly.
  virtual void to_json(GenesView genes, JsonWriter& out) const = 0;
  /// The inverse. Throws std::runtime_error on what it cannot use.
  virtual void from_json(const JsonReader& in, Genes& genes) const = 0;
  /// Throws std::runtime_error, saying why, unless the genes are well formed and fit `layout`.
  virtual void check(const Layout& layout, GenesView genes) const = 0;
};

}  // namespace somas
