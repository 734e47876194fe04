#include "core/geometry/camera_bytes.h"

namespace kinegraph {

void Put(const Camera& camera, ByteWriter* writer) {
  writer->PutText(camera.name());
  writer->Put(camera.width_px());
  writer->Put(camera.height_px());
  writer->PutMatrix(camera.K());
  writer->PutMatrix(camera.R());
  writer->PutMatrix(camera.t());
  writer->PutText(camera.lens() ? camera.lens()->model() : "");
  if (!camera.lens()) return;
  for (const double value : camera.lens()->parameters()) writer->Put(value);
}

}  // namespace kinegraph
