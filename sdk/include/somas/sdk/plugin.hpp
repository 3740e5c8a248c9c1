/// @file
/// Everything a plugin includes. A whole plugin:
///
/// @code
///   #include <somas/sdk/plugin.hpp>
///   class Breeze final : public somas::Environment {
///    public:
///     static constexpr somas::About about{"breeze", "A constant force on every cell"};
///     struct Parameters {
///       double strength = 0.1;
///       void describe(somas::Describe& d) { d("strength", strength, "Force along x"); }
///     };
///     explicit Breeze(const Parameters& p) : p_(p) {}
///     void declare(somas::Declare& d) override { d.acts_in(somas::Phase::forces); }
///     void act(somas::Phase, somas::World& world) const override {
///       for (double& f : world.force_x()) f += p_.strength;
///     }
///    private:
///     Parameters p_;
///   };
///   SOMAS_PLUGIN("example.breeze", "1.0", Breeze)
/// @endcode
#pragma once

#include <array>
#include <concepts>
#include <type_traits>

#include "somas/sdk/abi.hpp"
#include "somas/sdk/controller.hpp"
#include "somas/sdk/environment.hpp"
#include "somas/sdk/extension.hpp"
#include "somas/sdk/fitness.hpp"
#include "somas/sdk/heritable.hpp"
#include "somas/sdk/layout.hpp"
#include "somas/sdk/log.hpp"
#include "somas/sdk/math.hpp"
#include "somas/sdk/parameters.hpp"
#include "somas/sdk/rng.hpp"
#include "somas/sdk/specialization.hpp"
#include "somas/sdk/types.hpp"
#include "somas/sdk/workers.hpp"
#include "somas/sdk/world.hpp"

namespace somas::detail {

template <class T>
concept PluginClass = Described<typename T::Parameters> &&
    std::constructible_from<T, const typename T::Parameters&> &&
    (std::derived_from<T, Environment> || std::derived_from<T, Specialization> ||
     std::derived_from<T, Controller> || std::derived_from<T, Fitness>);

template <class T>
consteval PluginKind kind_of() {
  if (std::is_base_of_v<Environment, T>) return PluginKind::environment;
  if (std::is_base_of_v<Specialization, T>) return PluginKind::specialization;
  if (std::is_base_of_v<Controller, T>) return PluginKind::controller;
  return PluginKind::fitness;
}

template <class T>
using InterfaceOf = std::conditional_t<
    std::is_base_of_v<Environment, T>, Environment,
    std::conditional_t<std::is_base_of_v<Specialization, T>, Specialization,
                       std::conditional_t<std::is_base_of_v<Controller, T>, Controller, Fitness>>>;

template <PluginClass T>
ClassInfo class_info() {
  // Lives as long as the library: the table points into it.
  static const Describe described = [] {
    Describe d;
    typename T::Parameters parameters{};
    parameters.describe(d);
    return d;
  }();
  ClassInfo info;
  info.kind = kind_of<T>();
  info.id = T::about.id;
  info.doc = T::about.doc;
  info.parameters = described.parameters().data();
  info.parameter_count = described.parameters().size();
  info.create = [](const Value* values) -> void* {
    typename T::Parameters parameters{};
    Describe reader(*values);
    parameters.describe(reader);
    return static_cast<InterfaceOf<T>*>(new T(parameters));
  };
  info.destroy = [](void* instance) { delete static_cast<InterfaceOf<T>*>(instance); };
  return info;
}

template <PluginClass... Classes>
const PluginInfo* plugin_info(const char* id, const char* version) {
  static const std::array<ClassInfo, sizeof...(Classes)> classes{class_info<Classes>()...};
  static const PluginInfo info = [&] {
    PluginInfo p;
    p.fingerprint = SOMAS_FINGERPRINT;
    p.id = id;
    p.version = version;
    p.classes = classes.data();
    p.class_count = classes.size();
    p.attach = &attach;
    return p;
  }();
  return &info;
}

}  // namespace somas::detail

/// Makes the translation unit's library a plugin: once per library, at namespace scope. `id` and
/// `version` are string literals: who the library is ("example.breeze", dotted lower_snake_case),
/// and its version, which runs record. Then come the plugin classes, at least one, of any kinds.
#define SOMAS_PLUGIN(id, version, ...)                                                        \
  __attribute__((section(".note.somas"), used,                                                \
                 aligned(4))) static const somas::PluginNote somas_plugin_note{};             \
  extern "C" __attribute__((visibility("default"))) const somas::PluginInfo* somas_plugin() { \
    return somas::detail::plugin_info<__VA_ARGS__>(id, version);                              \
  }
