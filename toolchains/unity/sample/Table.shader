// The table as the camera shows it, darkened by the shadows of sand and objects (runtime/shadow/README.md). It is drawn
// before what stands on it. Where an AROcclusionManager has written the depth of what is real, that hides it: so all is drawn
// nearer to the eye by the same share, where it stays on its pixels, and only what is higher than `bias` hides what lies on
// the table. Colours are linear, and so must be the project's colour space. With ON_MESH it draws what is real upon the table and has a
// mesh, as an ARMeshManager makes it: there the shadows of objects are those at its height.
Shader "Sandglass/Table" {
  SubShader {
    Tags { "RenderType" = "Transparent" "Queue" = "Geometry-10" }
    Blend SrcAlpha OneMinusSrcAlpha
    ZWrite Off
    Cull Off
    Pass {
      CGPROGRAM
      #pragma target 4.5
      #pragma vertex vertex
      #pragma fragment fragment
      #pragma multi_compile _ ON_MESH
      #include "UnityCG.cginc"

      Texture2D<float> _Object, _ObjectRoom, _Sand, _SandRoom;
      SamplerState linear_clamp_sampler;
      float4 _ObjectBox, _ObjectRoomBox, _SandBox, _SandRoomBox;  // a corner, and one over the extents; 0: there is none
      float3 _Origin;  // in Unity's world
      float _HalfSide, _MainShare, _SandOpacity, _Nearer, _Height;  // _Height: metres up to the objects' last layer
      float2 _Slide;                                                // of their shadow, a metre up

      struct Corner { float4 position : SV_POSITION; float3 place : TEXCOORD0; };  // from the origin, right-handed

      Corner cornerAt(float3 place) {
        Corner corner;
        corner.place = place;
        float4 view = mul(UNITY_MATRIX_V, float4(_Origin + float3(place.xy, -place.z), 1));
        corner.position = mul(UNITY_MATRIX_P, float4(view.xyz * _Nearer, 1));
        return corner;
      }
      #ifdef ON_MESH
      Corner vertex(float4 position : POSITION) { return cornerAt((mul(unity_ObjectToWorld, position).xyz - _Origin) * float3(1, 1, -1)); }
      #else
      Corner vertex(uint index : SV_VertexID) {
        static const float2 corners[6] = { float2(-1, -1), float2(1, -1), float2(1, 1), float2(-1, -1), float2(1, 1), float2(-1, 1) };
        return cornerAt(_HalfSide * float3(corners[index].x, 0, corners[index].y));
      }
      #endif

      float at(Texture2D<float> map, float4 box, float2 place, float above, float outside) {  // sandglass/cast.h
        float2 p = (place - box.xy) * box.zw;
        uint side, rows;
        map.GetDimensions(side, rows);
        float number = rows / side, layer = saturate(above / _Height) * (number - 1), lower = floor(layer);
        float row = clamp(p.y, 0.5 / side, 1 - 0.5 / side);
        float low = map.Sample(linear_clamp_sampler, float2(p.x, (lower + row) / number));
        float high = map.Sample(linear_clamp_sampler, float2(p.x, (min(lower + 1, number - 1) + row) / number));
        return box.z > 0 && all(p == saturate(p)) ? lerp(low, high, layer - lower) : outside;
      }

      fixed4 fragment(Corner corner) : SV_Target {
        float s = _MainShare, above = max(corner.place.y, 0);
        float2 place = corner.place.xz;
        float sharp = (1 - at(_Object, _ObjectBox, place - above * _Slide, above, 0)) * (1 - _SandOpacity * at(_Sand, _SandBox, place, 0, 0));
        float rest = max(at(_ObjectRoom, _ObjectRoomBox, place, above, 1) - s, 0) * max(at(_SandRoom, _SandRoomBox, place, 0, 1) - s, 0);
        return fixed4(0, 0, 0, 1 - (s * sharp + (s < 1 ? rest / (1 - s) : 0)));
      }
      ENDCG
    }
  }
}
