#include "my_plugin.hpp"

// The library's id (yours, so that others can tell it from theirs), its version, its classes.
SOMAS_PLUGIN("example.my_plugin", "0.1.0", MyPlugin)
