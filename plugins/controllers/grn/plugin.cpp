#include "somas/sdk/plugin.hpp"

#include "plugins/controllers/grn/grn.hpp"

SOMAS_PLUGIN("somas.grn", "0.1.0", somas::grn::Grn)
