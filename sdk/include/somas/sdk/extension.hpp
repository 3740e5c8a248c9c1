/// @file
/// How the interface grows without breaking what is built: no class gets a new virtual function;
/// what is new is a class of its own that is asked for by name, "somas.NAME/VERSION".
#pragma once

#include <string_view>

namespace somas {

/// Base of every class that crosses the boundary, on either side of it.
///
/// An extension is an abstract class `E` with `static constexpr std::string_view extension_id`. Who
/// implements it returns a pointer to it for its id; who does not know the id returns null, so both
/// an older host and an older plugin go on working. The meaning of an id never changes.
class Extensible {
 public:
  virtual ~Extensible() = default;
  /// The extension of that id (a pointer to its class, as void*), or null. It lives as long as this
  /// object. Any thread, any time; the same answer every time.
  [[nodiscard]] virtual void* extension(std::string_view id) const {
    static_cast<void>(id);
    return nullptr;
  }
};

/// The extension `E` of an object, or null where it has none.
template <class E>
[[nodiscard]] E* extension_of(const Extensible& object) {
  return static_cast<E*>(object.extension(E::extension_id));
}

}  // namespace somas
