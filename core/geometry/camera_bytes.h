// A camera as bytes, for keys (core/base/piece_store.h): there is no way back.
#ifndef KINEGRAPH_CORE_GEOMETRY_CAMERA_BYTES_H_
#define KINEGRAPH_CORE_GEOMETRY_CAMERA_BYTES_H_

#include "core/base/bytes.h"
#include "core/geometry/camera.h"

namespace kinegraph {

// All of it: name, size, K, R, t and the lens.
void Put(const Camera& camera, ByteWriter* writer);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_CAMERA_BYTES_H_
