#include "somas/sdk/plugin.hpp"

#include "plugins/controllers/ctrnn/ctrnn.hpp"

SOMAS_PLUGIN("somas.ctrnn", "0.1.0", somas::ctrnn::Ctrnn)
