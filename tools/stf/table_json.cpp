// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/table_json.h"

namespace stf {

nlohmann::json describeTable(const StfTable& t) {
    return {{"kind", "transport table"},
            {"form", name(t.form)},
            {"size", {t.size.x, t.size.y, t.size.z}},
            {"polars", t.directions.polars()},
            {"azimuths", t.directions.azimuths()},
            {"directions", t.directions.count()},
            {"photons", t.photons},
            {"collisions", t.collisions},
            {"seed", t.seed},
            {"relativeError", t.error.total()},
            {"error",
             {{"target", t.error.target},
              {"noise", t.error.noise},
              {"directions", t.error.directions},
              {"truncation", t.error.truncation},
              {"filter", t.error.filter},
              {"storage", t.error.storage}}},
            {"bytes", t.bytes()},
            {"fileBytes", t.fileBytes},
            {"seconds", t.seconds},
            {"algorithm", t.algorithm},
            {"hash", t.volumeHash}};
}

} // namespace stf
