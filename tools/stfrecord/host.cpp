// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/host.h"

#include "tools/stfrecord/bufferReader.h"
#include "tools/stfrecord/recordTask.h"
#include "tools/stfrecord/stageScene.h"

#include "pxr/base/arch/systemInfo.h"
#include "pxr/base/plug/registry.h"
#include "pxr/base/tf/pathUtils.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hd/engine.h"
#include "pxr/imaging/hd/pluginRenderDelegateUniqueHandle.h"
#include "pxr/imaging/hd/renderBuffer.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/rendererPlugin.h"
#include "pxr/imaging/hd/rendererPluginRegistry.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <stdexcept>
#include <thread>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

/// Serves the descriptions of the render buffers.
class BufferDelegate final : public HdSceneDelegate {
public:
    explicit BufferDelegate(HdRenderIndex* index) : HdSceneDelegate(index, SdfPath("/__stfrecord")) {}

    HdRenderBufferDescriptor GetRenderBufferDescriptor(const SdfPath& id) override {
        const auto it = descriptors_.find(id);
        return it == descriptors_.end() ? HdRenderBufferDescriptor() : it->second;
    }
    std::map<SdfPath, HdRenderBufferDescriptor> descriptors_;
};

} // namespace

struct Host::Impl {
    // Destroyed from the bottom up: task, buffers, scene, index, delegate.
    UsdStageRefPtr stage;
    HdPluginRenderDelegateUniqueHandle delegate;
    std::unique_ptr<HdRenderIndex> index;
    std::unique_ptr<StageScene> scene;
    std::unique_ptr<BufferDelegate> buffers;
    HdEngine engine;
    std::shared_ptr<RecordTask> task;
    Window frame; // in pixels of the image
    float pixelAspectRatio = 1;
    TfTokenVector renderTags = {HdRenderTagTokens->geometry};

    void removeBuffers() {
        for (const auto& [id, descriptor] : buffers->descriptors_) {
            index->RemoveBprim(HdPrimTypeTokens->renderBuffer, id);
        }
        buffers->descriptors_.clear();
    }
};

Host::Host(const UsdStageRefPtr& stage, const TfToken& pluginId) : impl_(new Impl) {
    impl_->stage = stage;
    impl_->delegate = HdRendererPluginRegistry::GetInstance().CreateRenderDelegate(pluginId);
    if (!impl_->delegate) {
        throw std::runtime_error("renderer " + pluginId.GetString() + " cannot be loaded, or does not run here");
    }
    const TfTokenVector& bprims = impl_->delegate->GetSupportedBprimTypes();
    if (std::find(bprims.begin(), bprims.end(), HdPrimTypeTokens->renderBuffer) == bprims.end()) {
        throw std::runtime_error("renderer " + pluginId.GetString() + " has no render buffers: it needs a window");
    }
    impl_->index.reset(HdRenderIndex::New(impl_->delegate.Get(), {}));
    if (!impl_->index) {
        throw std::runtime_error("renderer " + pluginId.GetString() + " gives no render index");
    }
    impl_->buffers = std::make_unique<BufferDelegate>(impl_->index.get());
}

Host::~Host() {
    impl_->task.reset();
    if (impl_->buffers) {
        impl_->removeBuffers();
    }
    impl_->scene.reset();
    impl_->buffers.reset();
}

HdRenderDelegate& Host::delegate() {
    return *impl_->delegate;
}

void Host::populate(const std::vector<std::string>& purposes, int refineLevel, bool sceneIndices) {
    const auto has = [&purposes](const char* name) {
        return std::find(purposes.begin(), purposes.end(), name) != purposes.end();
    };
    impl_->renderTags.clear();
    if (has("default")) {
        impl_->renderTags.push_back(HdRenderTagTokens->geometry);
    }
    for (const TfToken& tag : {HdRenderTagTokens->render, HdRenderTagTokens->proxy, HdRenderTagTokens->guide}) {
        if (has(tag.GetText())) {
            impl_->renderTags.push_back(tag);
        }
    }
    impl_->scene = std::make_unique<StageScene>(
        *impl_->index, impl_->stage, sceneIndices ? StageScene::Way::SceneIndices : StageScene::Way::Delegate, purposes,
        refineLevel);
}

void Host::fillFrame(float pixelAspectRatio) {
    impl_->pixelAspectRatio = pixelAspectRatio;
    impl_->scene->fillFrame();
}

std::vector<std::string> Host::setOutputs(const std::vector<std::string>& aovs, int frameWidth, int frameHeight,
                                          const HdStfWindow& window) {
    impl_->task.reset();
    impl_->removeBuffers();
    std::vector<std::string> unknown;
    HdRenderPassAovBindingVector bindings;
    for (const std::string& name : aovs) {
        HdAovDescriptor aov = impl_->delegate->GetDefaultAovDescriptor(TfToken(name));
        if (aov.format == HdFormatInvalid) {
            unknown.push_back(name);
            continue;
        }
        HdRenderPassAovBinding binding;
        binding.aovName = TfToken(name);
        binding.renderBufferId =
            impl_->buffers->GetDelegateID().AppendChild(TfToken("aov_" + TfMakeValidIdentifier(name)));
        binding.clearValue = aov.clearValue;
        binding.aovSettings = aov.aovSettings;
        impl_->buffers->descriptors_[binding.renderBufferId] = {GfVec3i(window.width, window.height, 1), aov.format,
                                                                aov.multiSampled};
        impl_->index->InsertBprim(HdPrimTypeTokens->renderBuffer, impl_->buffers.get(), binding.renderBufferId);
        bindings.push_back(binding);
    }
    impl_->task = std::make_shared<RecordTask>(*impl_->index, bindings, frameWidth, frameHeight, impl_->renderTags);
    impl_->task->setPixelAspectRatio(impl_->pixelAspectRatio);
    impl_->frame = {-window.x, window.y + window.height - frameHeight, frameWidth, frameHeight};
    return unknown;
}

bool Host::render(const SdfPath& camera, UsdTimeCode time, const std::function<bool()>& poll) {
    impl_->scene->setCameraForSampling(camera);
    impl_->scene->applyPendingUpdates();
    impl_->scene->setTime(time);
    impl_->task->setCamera(camera);
    HdTaskSharedPtrVector tasks = {impl_->task};
    auto pause = std::chrono::milliseconds(1);
    for (;;) {
        impl_->engine.Execute(impl_->index.get(), &tasks);
        if (impl_->task->isConverged()) {
            return true;
        }
        if (!poll()) {
            if (impl_->delegate->IsStopSupported()) {
                impl_->delegate->Stop();
            }
            return false;
        }
        std::this_thread::sleep_for(pause);
        pause = std::min(2 * pause, std::chrono::milliseconds(50));
    }
}

Image Host::readImage() const {
    Image image;
    image.frame = impl_->frame;
    image.pixelAspectRatio = impl_->pixelAspectRatio;
    for (const HdRenderPassAovBinding& binding : impl_->task->bindings()) {
        auto* buffer = static_cast<HdRenderBuffer*>(
            impl_->index->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
        if (!buffer) {
            continue;
        }
        image.layers.push_back(readLayer(*buffer, binding.aovName.GetString()));
        image.width = int(buffer->GetWidth());
        image.height = int(buffer->GetHeight());
    }
    return image;
}

TfToken findRenderer(const std::string& name, std::vector<std::string>& available) {
    HfPluginDescVector descriptions;
    HdRendererPluginRegistry::GetInstance().GetPluginDescs(&descriptions);
    const std::string wanted = TfStringToLower(name);
    for (const HfPluginDesc& description : descriptions) {
        if (TfStringToLower(description.displayName) == wanted || TfStringToLower(description.id) == wanted) {
            return description.id;
        }
        available.push_back(description.displayName);
    }
    return TfToken();
}

void registerPlugins() {
    const std::string folder = TfGetPathName(ArchGetExecutablePath());
    PlugRegistry::GetInstance().RegisterPlugins(TfNormPath(folder + "../plugin") + "/");
}

} // namespace stfrecord
