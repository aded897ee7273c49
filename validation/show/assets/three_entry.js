export { BufferAttribute, BufferGeometry, Color, DataTexture, DoubleSide, FloatType, Group, LineSegments, Mesh, NearestFilter, OrthographicCamera, Points, RGBAFormat, RawShaderMaterial, GLSL3, Scene, Vector3, Vector2, WebGLRenderTarget, WebGLRenderer } from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
