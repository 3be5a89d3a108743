// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fuzz_session.h"

#include <functional>
#include <string>
#include <vector>

namespace fuzz {

/// One kind of edit. `apply` says what it did, in a line; nothing where it found nothing to edit.
struct EditKind {
    std::string name;
    int weight; ///< how often it is chosen, beside others
    std::function<std::string(Session&, Random&)> apply;
};

using EditKinds = std::vector<EditKind>;

// By what they edit, one file each.
void addMeshEdits(EditKinds& kinds);
void addGprimEdits(EditKinds& kinds);
void addSubsetEdits(EditKinds& kinds);
void addShellEdits(EditKinds& kinds);
void addMaterialEdits(EditKinds& kinds);
void addLightEdits(EditKinds& kinds);
void addInstancerEdits(EditKinds& kinds);
void addViewEdits(EditKinds& kinds);

/// All of them.
const EditKinds& editKinds();

} // namespace fuzz
