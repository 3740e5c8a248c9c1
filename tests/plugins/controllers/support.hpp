// What the tests of controllers share: layouts, batches, JSON over nlohmann, laws of heredity.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "somas/sdk/controller.hpp"

namespace somas::testing {

// ---- layouts -----------------------------------------------------------------------------------

/// A layout that owns its names. Every state has the same input channels; the key of an input is
/// that of "STATE.NAME", the key of an output that of its name.
class TestLayout {
 public:
  TestLayout(std::vector<std::string> states, std::vector<std::string> inputs,
             std::vector<std::string> outputs) {
    for (const std::string& state : states) {
      const auto index = static_cast<std::uint16_t>(states_.size());
      states_.push_back({keep(state), stable_key(state), index == 0 ? no_state : std::uint16_t{0}});
      for (std::uint32_t c = 0; c < inputs.size(); ++c) {
        const std::string_view name = keep(state + "." + inputs[c]);
        inputs_.push_back({name, stable_key(name), c, index});
      }
    }
    for (std::uint32_t c = 0; c < outputs.size(); ++c) {
      const std::string_view name = keep(outputs[c]);
      outputs_.push_back({name, stable_key(name), c, no_state});
    }
    channels_ = static_cast<std::uint32_t>(inputs.size());
  }

  [[nodiscard]] Layout view() const { return {states_, inputs_, outputs_, channels_}; }

 private:
  std::string_view keep(std::string text) { return names_.emplace_back(std::move(text)); }

  std::deque<std::string> names_;
  std::vector<StateInfo> states_;
  std::vector<Port> inputs_;
  std::vector<Port> outputs_;
  std::uint32_t channels_ = 0;
};

/// The ports of the paper's second experiment, roughly: 3 states of 7 inputs, 10 outputs.
inline TestLayout rich_layout() {
  return {
      {"nutritive", "defensive", "storage"},
      {"morphogen_0", "morphogen_1", "morphogen_2", "pressure", "energy", "ambrosia", "nutrients"},
      {"quiescence", "apoptosis", "division", "specialize.defensive", "specialize.storage",
       "morphogen_0", "morphogen_1", "conversion", "diffusion", "uptake"}};
}

// ---- cells -------------------------------------------------------------------------------------

/// The memory of a batch. `stride` may exceed the lanes: what lies between must stay untouched.
struct Cells {
  Cells(const Program& program, const Layout& layout, std::uint32_t lane_count,
        std::size_t row_stride = 0)
      : lanes(lane_count),
        stride(row_stride > 0 ? row_stride : lane_count),
        memory_rows(program.memory_per_cell()),
        input_rows(layout.input_channels),
        output_rows(static_cast<std::uint32_t>(layout.outputs.size())),
        in(input_rows * stride),
        memory(memory_rows * stride),
        out(output_rows * stride) {}

  /// The cells [first, first + count), all in `state`.
  [[nodiscard]] Batch batch(std::uint16_t state, std::uint32_t first, std::uint32_t count) {
    Batch b;
    b.count = count;
    b.state = state;
    b.in = {in.data() + first, input_rows, count, stride};
    b.memory = {memory.data() + first, memory_rows, count, stride};
    b.out = {out.data() + first, output_rows, count, stride};
    return b;
  }
  [[nodiscard]] Batch batch(std::uint16_t state) { return batch(state, 0, lanes); }

  std::uint32_t lanes;
  std::size_t stride;
  std::uint32_t memory_rows;
  std::uint32_t input_rows;
  std::uint32_t output_rows;
  std::vector<float> in;
  std::vector<float> memory;
  std::vector<float> out;
};

inline void fill_uniform(std::vector<float>& values, Rng& rng) {
  for (float& value : values) value = static_cast<float>(rng.uniform());
}

inline Rng test_rng(std::uint64_t number) { return {20140730, 0, 0, 1, number}; }

// ---- JSON --------------------------------------------------------------------------------------

class JsonOut final : public JsonWriter {
 public:
  JsonOut() { open_.push_back(&root_); }
  void open_object(std::string_view key) override { open(key, nlohmann::json::object()); }
  void open_list(std::string_view key) override { open(key, nlohmann::json::array()); }
  void close() override { open_.pop_back(); }
  void number(std::string_view key, double value) override { put(key, value); }
  void integer(std::string_view key, std::int64_t value) override { put(key, value); }
  void text(std::string_view key, std::string_view value) override { put(key, value); }
  void key64(std::string_view key, std::uint64_t value) override {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value));
    put(key, digits);
  }

  /// The text; every container must have been closed.
  [[nodiscard]] std::string dump() const {
    if (open_.size() != 1) throw std::logic_error("unbalanced open and close");
    return root_.dump();
  }

 private:
  nlohmann::json& put(std::string_view key, nlohmann::json value) {
    nlohmann::json& parent = *open_.back();
    if (parent.is_array() != key.empty()) throw std::logic_error("key in a list, or none outside");
    if (parent.is_array()) {
      parent.push_back(std::move(value));
      return parent.back();
    }
    return parent[std::string(key)] = std::move(value);
  }
  void open(std::string_view key, nlohmann::json value) {
    open_.push_back(&put(key, std::move(value)));
  }

  nlohmann::json root_ = nlohmann::json::object();
  std::vector<nlohmann::json*> open_;
};

class JsonIn final : public JsonReader {
 public:
  explicit JsonIn(const std::string& text) : JsonIn(nlohmann::json::parse(text)) {}
  explicit JsonIn(nlohmann::json value) : value_(std::move(value)) {}

  bool has(std::string_view key) const override { return value_.contains(std::string(key)); }
  const JsonReader& member(std::string_view key) const override {
    return child(value_.at(std::string(key)));
  }
  std::size_t size() const override { return value_.size(); }
  const JsonReader& item(std::size_t i) const override { return child(value_.at(i)); }
  double number() const override { return value_.get<double>(); }
  std::int64_t integer() const override { return value_.get<std::int64_t>(); }
  std::string_view text() const override { return value_.get_ref<const std::string&>(); }
  std::uint64_t key64() const override {
    return std::strtoull(value_.get<std::string>().c_str(), nullptr, 16);
  }

 private:
  const JsonReader& child(const nlohmann::json& value) const {
    return *children_.emplace_back(std::make_unique<JsonIn>(value));
  }

  nlohmann::json value_;
  mutable std::deque<std::unique_ptr<JsonIn>> children_;
};

inline std::string to_json_text(const Heritable& heritable, GenesView genes) {
  JsonOut out;
  heritable.to_json(genes, out);
  return out.dump();
}

// ---- laws --------------------------------------------------------------------------------------

inline Genes random_genes(const Heritable& heritable, const Layout& layout, std::uint64_t number) {
  Rng rng = test_rng(number);
  Genes genes;
  heritable.random(layout, rng, genes);
  return genes;
}

/// Genes that have been through `events` mutations.
inline Genes evolved_genes(const Heritable& heritable, const Layout& layout, std::uint64_t number,
                           int events) {
  Genes genes = random_genes(heritable, layout, number);
  Rng rng = test_rng(number + 1'000'000);
  for (int i = 0; i < events; ++i) heritable.mutate(layout, rng, genes);
  return genes;
}

/// The message with which `call` throws std::runtime_error; none when it returns.
inline std::optional<std::string> error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return std::nullopt;
}

/// What somas/sdk/heritable.hpp promises of every heritable part, over many random genomes.
inline void expect_laws_of_heredity(const Heritable& heritable, const Layout& layout, int draws) {
  for (int i = 0; i < draws; ++i) {
    SCOPED_TRACE(i);
    const auto number = static_cast<std::uint64_t>(i);
    const Genes a = evolved_genes(heritable, layout, 2 * number, i % 30);
    const Genes b = evolved_genes(heritable, layout, 2 * number + 1, i % 17);
    ASSERT_NO_THROW(heritable.check(layout, a));

    Rng rng = test_rng(5'000'000 + number);
    Genes child;
    heritable.cross(layout, a, b, rng, child);
    ASSERT_NO_THROW(heritable.check(layout, child));
    heritable.cross(layout, a, a, rng, child);
    ASSERT_EQ(child, a);

    ASSERT_EQ(heritable.distance(a, a), 0.0);
    ASSERT_GT(heritable.distance(a, b), 0.0);
    ASSERT_LE(heritable.distance(a, b), 1.0);
    ASSERT_EQ(heritable.distance(a, b), heritable.distance(b, a));

    Genes same = a;
    heritable.conform(layout, rng, same);
    ASSERT_EQ(same, a);

    const JsonIn json(to_json_text(heritable, a));
    heritable.from_json(json, same);
    ASSERT_EQ(same, a);
  }
}

/// Every shortened, lengthened or mislabelled copy of `genes` is refused with a message.
inline void expect_corruption_refused(const Heritable& heritable, const Layout& layout,
                                      const Genes& genes) {
  for (std::size_t length = 0; length < genes.size(); ++length) {
    const auto error = error_of([&] { heritable.check(layout, GenesView(genes).first(length)); });
    ASSERT_TRUE(error.has_value()) << length << " of " << genes.size() << " bytes";
    ASSERT_FALSE(error->empty());
  }
  Genes longer = genes;
  longer.push_back(0);
  EXPECT_TRUE(error_of([&] { heritable.check(layout, longer); }));
  // Counts of 2^32 - 1 must be refused before anything is allocated for them.
  for (std::size_t at = 0; at < 16; at += 4) {
    Genes corrupt = genes;
    for (std::size_t i = at; i < at + 4; ++i) corrupt[i] = 0xFF;
    EXPECT_TRUE(error_of([&] { heritable.check(layout, corrupt); })) << at;
  }
}

}  // namespace somas::testing
