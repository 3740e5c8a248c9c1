#include "somas/sdk/plugin.hpp"

#include "plugins/environments/walls/walls.hpp"

SOMAS_PLUGIN("somas.walls", "0.1.0", somas::environments::Walls)
