// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_reader.h"

namespace stf {

/// NIfTI, NRRD, MetaImage, TIFF (pages are layers) or one DICOM file, by the Insight Toolkit (ITK). Throws Error.
std::unique_ptr<ScanReader> openItk(const std::string& path);

/// A folder of slices: one DICOM series (by its UID where there are several), sorted by position, else TIFF files in
/// the order of the numbers in their names. Reports slices that are not equally far apart. Throws Error.
std::unique_ptr<ScanReader> openSlices(const std::string& folder, const std::string& series,
                                       const MessageSink& messages);

} // namespace stf
