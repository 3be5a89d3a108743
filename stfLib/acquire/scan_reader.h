// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan.h"
#include "stfLib/base/progress.h"

#include <memory>
#include <string>
#include <vector>

namespace stf {

/// Layout of a file without a header of its own.
struct RawLayout {
    Vec3i size{0, 0, 0};
    ScanType type = ScanType::UInt8;
    bool bigEndian = false;
    std::uint64_t headerBytes = 0;
};

/// What a reader must be told where files do not say it.
struct ScanReadOptions {
    bool raw = false; ///< read by `layout`, whatever the name
    RawLayout layout;
    std::string series; ///< UID of a DICOM series; empty: the only one
    std::string grid;   ///< of an OpenVDB file; empty: "density", or the only one of floats
};

/// What a file says of itself, without its voxels.
struct ScanHeader {
    std::string format; ///< "raw", "INR", "NIfTI", ...
    Vec3i size{0, 0, 0};
    Vec3d spacingMm{1, 1, 1};
    bool spacingKnown = false; ///< else 1 mm stands for what nobody said
    ScanType type = ScanType::UInt8;
};

/// A scan on disk: its header is read at once, voxels on demand.
class ScanReader {
public:
    virtual ~ScanReader() = default;
    const ScanHeader& header() const { return header_; }
    /// Memory that reading this part takes beside its values, in bytes: formats that cannot be read in parts take the
    /// whole scan.
    virtual std::uint64_t bufferBytes(const VoxelBox& box) const = 0;
    /// The values of a part, x fastest. Throws Error that names the file and where it ends early or is damaged, or that
    /// its byte order is wrong; Cancelled.
    virtual std::vector<float> read(const VoxelBox& box, Progress& progress) const = 0;

protected:
    ScanHeader header_;
};

/// Opens a scan: INR (.inr, .inr.gz), NIfTI, NRRD, MetaImage, TIFF (pages), DICOM, OpenVDB, a folder of DICOM or TIFF
/// slices, or raw by `options`. Throws Error that starts with the path: missing, unknown format, more than one value
/// per voxel, more than three dimensions, several series, sizes that cannot be.
std::unique_ptr<ScanReader> openScan(const std::string& path, const ScanReadOptions& options,
                                     const MessageSink& messages = {});

} // namespace stf
