// SPDX-License-Identifier: Apache-2.0
#include "test_host.h"

#include "hdStf/hydraCompat.h"

#include "pxr/base/tf/getenv.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/base/vt/dictionary.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/sdf/layer.h"

#include <algorithm>
#include <chrono>
#include <thread>

#ifdef __SANITIZE_ADDRESS__
/// OpenUSD keeps hundreds of blocks for the life of the process; leaks are looked for in the tests of stfLib.
extern "C" const char* __asan_default_options();
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() {
    return "detect_leaks=0";
}
#endif

PXR_NAMESPACE_USING_DIRECTIVE

bool TestHost::byIndices() {
    return TfGetenvBool("HDSTF_TEST_SCENE_INDICES", false);
}

bool TestHost::motionIsSampled() {
    return HDSTF_HAS_SAMPLING_INTERVAL || !byIndices();
}

bool TestHost::bindingEditsArrive() {
    return HDSTF_HAS_BINDING_EDITS || !byIndices();
}

bool TestHost::prototypeEditsArrive() {
    return !HDSTF_HAS_PRIM_ORIGINS || byIndices();
}

bool TestHost::nestedInstancersHide() {
    return PXR_VERSION != 2508 || !byIndices();
}

class TestHost::Buffers final : public HdSceneDelegate {
public:
    explicit Buffers(HdRenderIndex* index) : HdSceneDelegate(index, SdfPath("/__buffers")) {}
    HdRenderBufferDescriptor GetRenderBufferDescriptor(const SdfPath& id) override { return descriptors[id]; }
    std::map<SdfPath, HdRenderBufferDescriptor> descriptors;
};

namespace {

UsdStageRefPtr stageOf(const std::string& usda) {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    TF_AXIOM(layer->ImportFromString(usda));
    return UsdStage::Open(layer);
}

SdfPath bufferPath(const std::string& aov) {
    return SdfPath("/__buffers/" + TfMakeValidIdentifier(aov));
}

} // namespace

TestHost::TestHost(const std::string& usda, const std::vector<std::string>& aovs, int width, int height)
    : TestHost(stageOf(usda)) {
    setOutputs(aovs, width, height);
    delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(2));
}

TestHost::TestHost(const UsdStageRefPtr& stageToShow)
    : stage(stageToShow), delegate(std::make_unique<HdStfRenderDelegate>()) {
    index_.reset(HdRenderIndex::New(delegate.get(), {}));
    buffers_ = std::make_unique<Buffers>(index_.get());
    using stfrecord::StageScene;
    scene_ = std::make_unique<StageScene>(*index_, stage,
                                          byIndices() ? StageScene::Way::SceneIndices : StageScene::Way::Delegate,
                                          std::vector<std::string>{"default", "render", "proxy", "guide"});
    scene_->setCameraForSampling(SdfPath("/Camera"));
    scene_->setTime(UsdTimeCode::EarliestTime());
}

TestHost::~TestHost() {
    task_.reset();
    removeBuffers();
    scene_.reset();
    buffers_.reset();
    index_.reset();
    delegate.reset();
}

void TestHost::setOutputs(const std::vector<std::string>& aovs, int width, int height) {
    setOutputs(aovs, width, height, width, height);
}

const HdStfCamera& TestHost::camera() {
    return *static_cast<HdStfCamera*>(index_->GetSprim(HdPrimTypeTokens->camera, SdfPath("/Camera")));
}

HdRenderPassAovBinding TestHost::insertBuffer(const std::string& aov, int width, int height) {
    HdAovDescriptor descriptor = delegate->GetDefaultAovDescriptor(TfToken(aov));
    if (descriptor.format == HdFormatInvalid) {
        // What the delegate does not know, a careless host binds all the same.
        descriptor = HdAovDescriptor(HdFormatFloat32Vec3, false, VtValue(GfVec3f(0.25f)));
    }
    HdRenderPassAovBinding binding;
    binding.aovName = TfToken(aov);
    binding.clearValue = descriptor.clearValue;
    binding.renderBufferId = bufferPath(aov);
    const HdRenderBufferDescriptor wanted = {GfVec3i(width, height, 1), descriptor.format, descriptor.multiSampled};
    const bool isNew = buffers_->descriptors.count(binding.renderBufferId) == 0;
    HdRenderBufferDescriptor& held = buffers_->descriptors[binding.renderBufferId];
    if (isNew) {
        held = wanted;
        index_->InsertBprim(HdPrimTypeTokens->renderBuffer, buffers_.get(), binding.renderBufferId);
    } else if (held != wanted) {
        held = wanted;
        index_->GetChangeTracker().MarkBprimDirty(binding.renderBufferId, HdRenderBuffer::DirtyDescription);
    }
    return binding;
}

void TestHost::removeBuffers() {
    for (const auto& [id, descriptor] : buffers_->descriptors) {
        index_->RemoveBprim(HdPrimTypeTokens->renderBuffer, id);
    }
    buffers_->descriptors.clear();
}

void TestHost::setOutputs(const std::vector<std::string>& aovs, int width, int height, int frameWidth,
                          int frameHeight) {
    task_.reset();
    removeBuffers();
    HdRenderPassAovBindingVector bindings;
    for (const std::string& aov : aovs) {
        bindings.push_back(insertBuffer(aov, width, height));
    }
    task_ =
        std::make_shared<stfrecord::RecordTask>(*index_, bindings, frameWidth, frameHeight,
                                                TfTokenVector{HdRenderTagTokens->geometry, HdRenderTagTokens->render});
    task_->setCamera(SdfPath("/Camera"));
}

void TestHost::changeOutputs(const std::vector<std::string>& aovs, int width, int height, int frameWidth,
                             int frameHeight) {
    for (auto it = buffers_->descriptors.begin(); it != buffers_->descriptors.end();) {
        const bool stays =
            std::any_of(aovs.begin(), aovs.end(), [&](const std::string& aov) { return bufferPath(aov) == it->first; });
        if (!stays) {
            index_->RemoveBprim(HdPrimTypeTokens->renderBuffer, it->first);
        }
        it = stays ? std::next(it) : buffers_->descriptors.erase(it);
    }
    HdRenderPassAovBindingVector bindings;
    for (const std::string& aov : aovs) {
        bindings.push_back(insertBuffer(aov, width, height));
    }
    task_->setOutputs(bindings, frameWidth, frameHeight);
}

void TestHost::setCamera(const std::string& path) {
    scene_->setCameraForSampling(SdfPath(path));
    task_->setCamera(SdfPath(path));
}

void TestHost::execute() {
    scene_->applyPendingUpdates();
    if (beforeSync) {
        beforeSync();
    }
    HdTaskSharedPtrVector tasks = {task_};
    engine_.Execute(index_.get(), &tasks);
}

bool TestHost::renderToEnd() {
    const auto start = std::chrono::steady_clock::now();
    for (execute(); !converged(); execute()) {
        if (std::chrono::steady_clock::now() - start > std::chrono::minutes(1)) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

bool TestHost::restarts() {
    delegate->Pause(); // so that rendering cannot be over before we look
    execute();
    const bool restarted = !converged();
    delegate->Resume();
    return renderToEnd() && restarted;
}

HdStfRenderBuffer* TestHost::buffer(const std::string& aov) {
    return static_cast<HdStfRenderBuffer*>(index_->GetBprim(HdPrimTypeTokens->renderBuffer, bufferPath(aov)));
}

std::vector<float> TestHost::floats(const std::string& aov) {
    HdStfRenderBuffer* target = buffer(aov);
    const auto* data = static_cast<const float*>(target->Map());
    std::vector<float> result(data, data + size_t(target->GetWidth()) * target->GetHeight() *
                                               HdGetComponentCount(target->GetFormat()));
    target->Unmap();
    return result;
}

std::string TestHost::messages() {
    return VtDictionaryGet<std::string>(delegate->GetRenderStats(), "stf:messages");
}

std::string testScene(const std::string& squareProperties, const std::string& morePrims) {
    return R"(#usda 1.0
def Camera "Camera" { double3 xformOp:translate = (0, 0, 5); uniform token[] xformOpOrder = ["xformOp:translate"]; }
def DistantLight "Light" { float intensity = 1; float inputs:intensity = 1; float angle = 0; float inputs:angle = 0; }
def Mesh "Square" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    double3 xformOp:translate = (0, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
)" + squareProperties +
           "\n}\n" + morePrims + "\n";
}
