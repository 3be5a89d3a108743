// SPDX-License-Identifier: Apache-2.0
#pragma once

/// \file hydraCompat.h
/// What differs between the Hydras of OpenUSD 20.08 to 26.x, as named features. No other file of hdStf asks for a
/// version. Hosts back-port Hydra changes, so features follow HD_API_VERSION; PXR_VERSION decides only where the API
/// version did not move with the change.

#include "pxr/imaging/hd/version.h"
#include "pxr/pxr.h"

/// Constructors and factories of rprims and instancers take the parent instancer's id (to 20.11).
#define HDSTF_HAS_INSTANCER_ID_ARGUMENT (HD_API_VERSION < 36)
/// HdInstancer has a virtual Sync; rprims call `HdInstancer::_SyncInstancerAndParents` (from 21.02). Before that an
/// instancer pulls its primvars when first asked, under a lock of its own.
#define HDSTF_HAS_INSTANCER_SYNC (HD_API_VERSION >= 36)
/// Instancers are visible or not; before that their prototypes are.
#define HDSTF_HAS_INSTANCER_VISIBILITY (HD_API_VERSION >= 56)
/// Render pass states carry a CameraUtilFraming (from 21.02).
#define HDSTF_HAS_FRAMING (HD_API_VERSION >= 36)
/// Render pass states are bound around a pass (to 21.02), passes are prepared (to 21.08).
#define HDSTF_HAS_PASS_STATE_BIND (HD_API_VERSION < 41)
#define HDSTF_HAS_PASS_PREPARE (HD_API_VERSION < 42)
/// Spheres, cubes and the like arrive as such under scene indices, and a scene index turns them to meshes (from 23.08);
/// before that UsdImaging does.
#define HDSTF_HAS_IMPLICIT_SURFACES (HD_API_VERSION >= 54)
/// Render pass states have SetCamera and SetFraming (from 23.08).
#define HDSTF_HAS_SET_FRAMING (HD_API_VERSION >= 54)
/// UsdImaging has scene indices for stages (from 23.11), and a scene index in which a host sets the level of refinement
/// of all prims, as `SetRefineLevelFallback` from 26.05 on.
#define HDSTF_HAS_STAGE_SCENE_INDICES (HD_API_VERSION >= 56)
#define HDSTF_HAS_REFINE_LEVEL_FALLBACK (HD_API_VERSION >= 97)
/// Scene indices can be switched off for a process (to 26.05).
#define HDSTF_HAS_SCENE_INDEX_SWITCH (HD_API_VERSION >= 56 && HD_API_VERSION < 99)
/// Scene delegates are behind scene indices and no longer asked themselves for a prim's path in the scene; prims of
/// scene indices know where they are from (from 23.11, where hdStf asks).
#define HDSTF_HAS_PRIM_ORIGINS (HD_API_VERSION >= 56)
/// Prims may mark others as changed while all are synced (to 26.03); later Hydra holds that for an error.
#define HDSTF_HAS_DIRTYING_IN_SYNC (HD_API_VERSION < 94)
/// Edits of a material's binding arrive by scene indices, and so do those of subsets (from 24.08; in 24.05 the one that
/// resolves bindings drops them).
#define HDSTF_HAS_BINDING_EDITS (HD_API_VERSION >= 68)
/// Hydra has meshes of tetrahedra (from 24.05), and says what computed primvars depend on (from 24.11).
#define HDSTF_HAS_TET_MESHES (HD_API_VERSION >= 67)
#define HDSTF_HAS_COMPUTATION_DEPENDENCIES (HD_API_VERSION >= 74)
/// UsdImaging leaves light and shadow links as collections, and a scene index resolves them (from 24.08); before that
/// only scene delegates know links.
#define HDSTF_HAS_LINKS_AS_COLLECTIONS (HD_API_VERSION >= 71)
/// Transforms and primvars are sampled over an interval that the renderer names (from 24.08); before that over the
/// shutter of the camera that the host named to UsdImaging, and under scene indices not at all.
#define HDSTF_HAS_SAMPLING_INTERVAL (HD_API_VERSION >= 68)
/// Light parameters are read by the attribute's literal name, so that `inputs:` has to be asked for (to 20.11).
#define HDSTF_LIGHT_PARAMS_ARE_ATTRIBUTES (HD_API_VERSION < 36)
/// A light's transform is one of its parameters; GetTransform is a coding error (20.08 only).
#define HDSTF_LIGHT_TRANSFORM_IS_PARAM (PXR_VERSION < 2011)
/// Several material render contexts in place of one network selector (from 21.05).
#define HDSTF_HAS_MATERIAL_RENDER_CONTEXTS (HD_API_VERSION >= 41)
/// `Stop(bool blocking)`, `IsPaused()` and `IsStopped()` (from 22.03).
#define HDSTF_HAS_IS_STOPPED (HD_API_VERSION >= 44)
/// Sprims and bprims can be synced in parallel where the delegate says so (from 24.08).
#define HDSTF_HAS_PARALLEL_SYNC_QUERY (HD_API_VERSION >= 71)
/// HdRendererPlugin::IsSupported takes nothing (to 22.11), a flag for the GPU (23.02 to 25.08), creation arguments
/// (25.11 to 26.02), or their schema (from 26.05).
#define HDSTF_IS_SUPPORTED_TAKES_GPU_FLAG (HD_API_VERSION >= 46 && HD_API_VERSION < 83)
#define HDSTF_IS_SUPPORTED_TAKES_ARGS (HD_API_VERSION >= 83 && HD_API_VERSION < 98)
#define HDSTF_IS_SUPPORTED_TAKES_SCHEMA (HD_API_VERSION >= 98)
