// Views whose files count frames at rates of their own, or from numbers of
// their own: each is read at its own pace, and each of its frames joins the
// frame of the recording that is nearest in time, with its own time of capture.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_RATED_SOURCE_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_RATED_SOURCE_H_

#include <functional>
#include <memory>

#include "core/io/detections/source.h"

namespace kinegraph {

// `open` opens the files anew, all views at the recording's rate; the options'
// view_frame_rate_hz and view_frame_offset count. Of several frames of a view
// that lie nearest to the same frame of the recording, the nearest joins. The
// recording is read whole. Throws InputError for a view that there is not,
// where the recording's own rate is not known, and for files that tell the
// times of their frames.
std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_RATED_SOURCE_H_
