// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/usd/usd/primRange.h"
#include "fuzz_files.h"
#include "fuzz_random.h"
#include "test_host.h"

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace fuzz {

/// What a host says beside the stage: all of it is known, so that another host can be brought to the same state.
struct View {
    double time = 1;
    std::string camera = "/Camera";
    PXR_NS::TfTokenVector tags;
    int refineFallback = 0;
    std::map<PXR_NS::SdfPath, int> refine;
    std::vector<std::string> aovs;
    int width = 48, height = 32;           ///< of the buffers
    int frameWidth = 48, frameHeight = 32; ///< of the frame that they show part of
    std::map<PXR_NS::TfToken, PXR_NS::VtValue> settings;
};

/// Faults that are put in on purpose, outside the delegate: does the comparison see them?
enum class Sabotage {
    None,
    DirtyBit,  ///< changes of primvars do not reach meshes that are there
    Instancer, ///< changes of instancers do not reach them
    Aov,       ///< the first AOV shows what it showed at first
};

/// A stage, a host that shows it and follows its edits, and the comparison with a host that is made anew.
class Session {
public:
    explicit Session(Sabotage sabotage);
    ~Session();

    Files files;
    PXR_NS::UsdStageRefPtr stage;
    View view;
    TestHost& live() { return *live_; }

    /// Hands everything over and executes once, without waiting.
    void execute();
    void renderToEnd();
    /// Destroys the host and its delegate and makes others.
    void replaceHost();
    void pause();
    void stop();
    void goOn();

    /// Renders to the end, here and by a host made anew: empty where every AOV is the same, bit for bit; else what
    /// differs. Where images are the same, what the delegates hold of drawn meshes, of lights and materials is
    /// compared.
    std::string compare();

    /// Prims of a schema below /World and /Library, in the order of the stage.
    template<class Schema>
    std::vector<PXR_NS::UsdPrim> prims() const {
        std::vector<PXR_NS::UsdPrim> found;
        for (const PXR_NS::UsdPrim& prim : PXR_NS::UsdPrimRange::AllPrims(stage->GetPseudoRoot())) {
            if (prim.IsA<Schema>()) {
                found.push_back(prim);
            }
        }
        return found;
    }

private:
    void makeHost();
    void show(TestHost& host) const;
    void applySabotage();

    Sabotage sabotage_;
    std::unique_ptr<TestHost> live_;
    PXR_NS::HdStfRenderBuffer* held_ = nullptr; ///< mapped by the sabotage, which keeps its image as it is
    std::string heldAov_;
    std::set<PXR_NS::SdfPath> instancersSeen_; ///< by the sabotage of them
    bool paused_ = false, stopped_ = false;
};

} // namespace fuzz
