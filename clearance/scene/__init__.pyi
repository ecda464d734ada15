from clearance.scene.scene import Scene as Scene
