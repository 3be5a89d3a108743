// SPDX-License-Identifier: Apache-2.0
#include "edits.h"

namespace fuzz {

const EditKinds& editKinds() {
    static const EditKinds all = [] {
        EditKinds kinds;
        addMeshEdits(kinds);
        addGprimEdits(kinds);
        addSubsetEdits(kinds);
        addShellEdits(kinds);
        addMaterialEdits(kinds);
        addLightEdits(kinds);
        addInstancerEdits(kinds);
        addViewEdits(kinds);
        return kinds;
    }();
    return all;
}

} // namespace fuzz
