// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/camera.h"
#include "hdStf/renderBuffer.h"
#include "hdStf/renderDelegate.h"
#include "tools/stfrecord/recordTask.h"
#include "tools/stfrecord/stageScene.h"

#include "pxr/imaging/hd/engine.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/usd/usd/stage.h"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

/// A Hydra host for tests: a stage in memory, UsdImaging, the delegate's own classes, one task. The stage comes in by
/// UsdImaging's scene delegate, or by its scene indices where the environment says HDSTF_TEST_SCENE_INDICES=1.
class TestHost {
public:
    /// `usda` is the text of a layer; it needs a camera at /Camera.
    explicit TestHost(const std::string& usda, const std::vector<std::string>& aovs = {"color"}, int width = 16,
                      int height = 12);
    /// The same for a stage that is there, without outputs.
    explicit TestHost(const PXR_NS::UsdStageRefPtr& stageToShow);
    ~TestHost();

    static bool byIndices();
    /// Whether this OpenUSD gives transforms over a shutter, the way the stage comes in.
    static bool motionIsSampled();
    /// Whether edits of bindings and of subsets arrive, the way the stage comes in.
    static bool bindingEditsArrive();
    /// Whether edits of an instancer's prototypes arrive, the way the stage comes in.
    static bool prototypeEditsArrive();
    /// Whether nested instancers can be hidden, the way the stage comes in.
    static bool nestedInstancersHide();

    PXR_NS::UsdStageRefPtr stage;
    std::unique_ptr<PXR_NS::HdStfRenderDelegate> delegate;

    /// New buffers of that size, as a host does when its window changes.
    void setOutputs(const std::vector<std::string>& aovs, int width, int height);
    /// Which prims the task asks for; none: all of them.
    void setRenderTags(const PXR_NS::TfTokenVector& tags) { task_->setRenderTags(tags); }
    /// The same for a frame of another size than that of the buffers.
    void setOutputs(const std::vector<std::string>& aovs, int width, int height, int frameWidth, int frameHeight);
    /// The same for the same pass: buffers that stay are resized, others come and go.
    void changeOutputs(const std::vector<std::string>& aovs, int width, int height, int frameWidth, int frameHeight);
    void setTime(double time) { scene_->setTime(PXR_NS::UsdTimeCode(time)); }
    void setCamera(const std::string& path);
    stfrecord::StageScene& scene() { return *scene_; }
    PXR_NS::HdRenderIndex& index() { return *index_; }
    /// Called between the scene delegate's updates and Hydra's sync, if there is one.
    std::function<void()> beforeSync;
    const PXR_NS::HdStfCamera& camera();
    /// Hands pending edits over and executes once.
    void execute();
    bool converged() const { return task_->isConverged(); }
    /// Executes until converged; false after a minute.
    bool renderToEnd();
    /// Executes once; true if that started rendering anew. Leaves a converged image behind.
    bool restarts();

    PXR_NS::HdStfRenderBuffer* buffer(const std::string& aov);
    std::vector<float> floats(const std::string& aov);
    const stf::SceneMesh& mesh(const std::string& path) { return delegate->GetScene().meshes().at(path); }
    /// Texts of all messages so far.
    std::string messages();

private:
    class Buffers;
    PXR_NS::HdRenderPassAovBinding insertBuffer(const std::string& aov, int width, int height);
    void removeBuffers();

    std::unique_ptr<PXR_NS::HdRenderIndex> index_;
    std::unique_ptr<stfrecord::StageScene> scene_;
    std::unique_ptr<Buffers> buffers_;
    PXR_NS::HdEngine engine_;
    std::shared_ptr<stfrecord::RecordTask> task_;
};

/// A layer with a camera, a light, a unit square /Square (more properties of it as text) and further prims.
std::string testScene(const std::string& squareProperties = {}, const std::string& morePrims = {});
