// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/exactness.h"

#include "stfLib/base/error.h"

#include <sstream>

namespace stf {

Exactness Exactness::parse(const std::string& names) {
    static constexpr struct {
        const char* name;
        bool Exactness::*flag;
    } kFlags[] = {{"levels", &Exactness::levels},
                  {"step", &Exactness::step},
                  {"coreTree", &Exactness::coreTree},
                  {"voxels", &Exactness::voxels},
                  {"directions", &Exactness::directions}};
    Exactness out;
    std::istringstream list(names);
    for (std::string word; std::getline(list, word, ',');) {
        bool known = false;
        for (const auto& f : kFlags) {
            if (word == f.name) {
                out.*f.flag = known = true;
            }
        }
        if (!known) {
            throw Error("stf:exact: no \"" + word + "\"; there is levels, step, coreTree, voxels, directions");
        }
    }
    return out;
}

} // namespace stf
