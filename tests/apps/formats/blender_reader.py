"""Run by Blender: imports a glTF and a BVH file, prints where joints stand.

    blender -b -P blender_reader.py -- take.glb person.bvh OUT.json FPS

Debian 12's Blender 3.4 meets a newer Python and NumPy than it was written for:
two names that these no longer know are given back to it.
"""

import builtins
import json
import sys

import bpy
import numpy

numpy.bool = bool
plain_open = builtins.open
builtins.open = lambda name, mode="r", *a, **k: plain_open(
    name, mode.replace("U", ""), *a, **k
)


def joints_of(armature):
    return {
        bone.name: list((armature.matrix_world @ bone.matrix).translation)
        for bone in armature.pose.bones
    }


gltf, bvh, out, fps = sys.argv[-4:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = int(fps)
bpy.ops.import_scene.gltf(filepath=gltf)
people = [o for o in bpy.data.objects if o.type == "ARMATURE"]
result = {"meshes": sum(o.type == "MESH" for o in bpy.data.objects), "gltf": [], "bvh": []}
for frame in range(40):
    scene.frame_set(frame)
    result["gltf"].append(
        {o.name: joints_of(o) for o in people if o.scale.x > 0.5}
    )
# Blender's BVH begins at its frame 1.
bpy.ops.import_anim.bvh(filepath=bvh, global_scale=0.01)
for frame in range(40):
    scene.frame_set(frame + 1)
    result["bvh"].append(joints_of(bpy.context.object))
with plain_open(out, "w") as file:
    json.dump(result, file)
