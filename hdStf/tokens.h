// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/tf/staticTokens.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// Render settings (docs/settings.md).
#define HDSTF_RENDER_SETTINGS_TOKENS                                                                                   \
    ((samples, "stf:samples"))((seed, "stf:seed"))((tableSeed, "stf:tableSeed"))((quality, "stf:quality"))(            \
        (transport, "stf:transport"))((integrator, "stf:integrator"))((errorTarget, "stf:errorTarget"))(               \
        (threads, "stf:threads"))((maxDepth, "stf:maxDepth"))((indirectClamp, "stf:indirectClamp"))(                   \
        (regularize, "stf:regularize"))((pixelFilter, "stf:pixelFilter"))((pixelFilterWidth, "stf:pixelFilterWidth"))( \
        (depthOfField, "stf:depthOfField"))((motionBlur, "stf:motionBlur"))((irradianceCache, "stf:irradianceCache"))( \
        (denoise, "stf:denoise"))((exact, "stf:exact"))((dataWindowNDC, "dataWindowNDC"))(                             \
        (stageMetersPerUnit, "stageMetersPerUnit"))

/// Constant primvars of StfShellAPI, as Hydra delivers them (without `primvars:`).
#define HDSTF_PRIMVAR_TOKENS                                                                                           \
    ((prefix, "stf:"))((baseVolume, "stf:baseVolume"))((thickness, "stf:thickness"))((scale, "stf:scale"))(            \
        (mapping, "stf:mapping"))((coreMaterial, "stf:coreMaterial"))((coreSigmaA, "stf:coreSigmaA"))(                 \
        (coreSigmaSPrime, "stf:coreSigmaSPrime"))((coreModel, "stf:coreModel"))((transport, "stf:transport"))(         \
        (quality, "stf:quality"))((seed, "stf:seed"))((rest, "stf:rest"))((orientation, "stf:orientation"))

/// Entries of GetRenderStats that hosts know, and those of hdStf's own.
#define HDSTF_STATS_TOKENS                                                                                             \
    (percentDone)(fractionDone)(                                                                                       \
        totalClockTime)(rendererName)(renderProgressAnnotation)(rendererStage)(totalMemory)(peakMemory)((              \
        stageFraction, "stf:stageFraction"))((plan, "stf:plan"))((messages, "stf:messages"))(                          \
        (precomputeSeconds, "stf:precomputeSeconds"))((synthesisSeconds, "stf:synthesisSeconds"))(                     \
        (shellSeconds, "stf:shellSeconds"))((coreSeconds, "stf:coreSeconds"))(                                         \
        (indirectSeconds, "stf:indirectSeconds"))((loadSeconds, "stf:loadSeconds"))(                                   \
        (firstPixelSeconds, "stf:firstPixelSeconds"))((renderSeconds, "stf:renderSeconds"))(                           \
        (syntheses, "stf:syntheses"))((grids, "stf:grids"))((poses, "stf:poses"))((tableBytes, "stf:tableBytes"))(     \
        (shellBytes, "stf:shellBytes"))((rays, "stf:rays"))((estimatedError, "stf:estimatedError"))(                   \
        (cryptoObject, "stf:cryptoObject"))

/// Names a material network may be authored for.
#define HDSTF_MATERIAL_TOKENS (stf)

/// Nodes and inputs of UsdPreviewSurface networks.
#define HDSTF_NETWORK_TOKENS                                                                                                                                                                                                                                                         \
    (surface)(UsdPreviewSurface)(                                                                                                                                                                                                                                                    \
        UsdUVTexture)(UsdTransform2d)(diffuseColor)(emissiveColor)(useSpecularWorkflow)(specularColor)(metallic)(roughness)(clearcoat)(clearcoatRoughness)(opacity)(opacityThreshold)(opacityMode)(ior)(normal)(displacement)(occlusion)(file)(st)(wrapS)(wrapT)(sourceColorSpace)(( \
        fileColorSpace, "colorSpace:file"))(                                                                                                                                                                                                                                         \
        scale)(bias)(fallback)(rotation)(translation)(in)(varname)(displayColor)(StfShell)

TF_DECLARE_PUBLIC_TOKENS(HdStfRenderSettingsTokens, , HDSTF_RENDER_SETTINGS_TOKENS);
TF_DECLARE_PUBLIC_TOKENS(HdStfPrimvarTokens, , HDSTF_PRIMVAR_TOKENS);
TF_DECLARE_PUBLIC_TOKENS(HdStfStatsTokens, , HDSTF_STATS_TOKENS);
TF_DECLARE_PUBLIC_TOKENS(HdStfMaterialTokens, , HDSTF_MATERIAL_TOKENS);
TF_DECLARE_PUBLIC_TOKENS(HdStfNetworkTokens, , HDSTF_NETWORK_TOKENS);

PXR_NAMESPACE_CLOSE_SCOPE
